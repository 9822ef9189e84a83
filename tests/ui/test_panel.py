"""The sidebar tab draws what there is, from properties and operators that exist."""

import webbrowser
from types import SimpleNamespace

import bpy
import pytest
from scene_building import add_ellipsoid, empty_scene


class Explained:
    """What an operator that explains a number is given: which number."""

    def __init__(self, drawn):
        object.__setattr__(self, "drawn", drawn)

    def __setattr__(self, name, value):
        summary = bpy.types.Object.bl_rna.properties["umbilics"].fixed_type
        assert name == "number" and value in summary.properties
        self.drawn.append(("number", value))


class Paper:
    """Stands for Blender's layout and remembers what was drawn on it."""

    def __init__(self, drawn=None):
        self.drawn = [] if drawn is None else drawn

    def _inside(self, **_):
        return Paper(self.drawn)

    row = column = box = split = grid_flow = _inside

    def separator(self, factor=1.0):
        pass

    def operator_menu_enum(self, name, _property, **_):
        self.operator(name)
        return SimpleNamespace()

    def prop_search(self, data, name, within, among, **_):
        assert among in within.bl_rna.properties, among
        self.prop(data, name)

    def template_list(self, cls, _name, data, name, active, active_name, **_):
        assert hasattr(bpy.types, cls)
        assert {name, active_name} <= set(data.bl_rna.properties.keys())
        self.drawn.append(("list", name))

    def prop_enum(self, data, name, value, **_):
        assert value in data.bl_rna.properties[name].enum_items
        self.prop(data, name)

    def prop(self, data, name, **_):
        assert name in data.bl_rna.properties, name
        self.drawn.append(("prop", name))

    def operator(self, name, text="", **_):
        group, _, short = name.partition(".")
        getattr(getattr(bpy.ops, group), short).get_rna_type()
        self.drawn.append(("operator", name))
        if name == "umbilics.explain":
            self.drawn.append(("label", text))
            return Explained(self.drawn)
        return SimpleNamespace()

    def label(self, text="", icon="NONE", icon_value=0):
        self.drawn.append(("label", text))

    def progress(self, factor=0.0, text=""):
        self.drawn.append(("progress", text))

    def names(self, kind):
        return [name for what, name in self.drawn if what == kind]


def panels():
    """The panels of the tab."""
    return [
        cls
        for cls in bpy.types.Panel.__subclasses__()
        if cls.__name__.startswith("UMBILICS_PT") and getattr(cls, "bl_category", "")
    ]


def drawn_panels():
    """Draw all panels of the tab that want to be seen; what was drawn."""
    paper = Paper()
    context = SimpleNamespace(
        scene=bpy.context.scene,
        active_object=bpy.context.active_object,
        region=SimpleNamespace(width=280),
        view_layer=bpy.context.view_layer,
        area=None,
        space_data=None,
        screen=None,
        preferences=SimpleNamespace(
            system=SimpleNamespace(ui_scale=1.0), addons=bpy.context.preferences.addons
        ),
    )
    for panel in panels():
        if not hasattr(panel, "poll") or panel.poll(context):
            panel.draw(SimpleNamespace(layout=paper), context)
    return paper


@pytest.fixture
def draw(addon):
    empty_scene()
    return drawn_panels


ADJUSTED = ("guide", "lines", "separatrices", "ridges", "preview_layout", "remesh_to_quads")


@pytest.mark.parametrize("name", ADJUSTED)
def test_adjusting_shows_what_has_an_effect(addon, name):
    """As the panel does, a number only where it is not left to the add-on."""
    operator = getattr(addon.operators, name)
    cls = getattr(operator, f"UMBILICS_OT_{name}")
    properties = bpy.context.window_manager.operator_properties_last(f"umbilics.{name}")
    every = {item.identifier for item in properties.bl_rna.properties} - {"rna_type"}
    switches = {item for item in every if item.endswith("_auto")}

    def shown():
        paper = Paper()
        settings = {item: getattr(properties, item) for item in every}
        idle = lambda: cls.idle(SimpleNamespace(**settings))  # noqa: E731
        cls.draw(SimpleNamespace(layout=paper, properties=properties, idle=idle), bpy.context)
        return paper.names("prop")

    for switch in switches:
        setattr(properties, switch, True)
    usual = every - {item.removesuffix("_auto") for item in switches}
    # Without a plane of symmetry nothing is mirrored.
    assert sorted(shown()) == sorted(usual - {"mirror_single"})
    if "symmetry" in every:
        properties.symmetry = "x"
    assert sorted(shown()) == sorted(usual)
    for switch in switches:
        setattr(properties, switch, False)
    # A length says how many quads there are.
    assert set(shown()) == every - ({"quads"} if "edge_length" in every else set())
    if "symmetry" in every:
        properties.symmetry = "none"


def test_tab_is_where_users_look(addon):
    for panel in panels():
        assert (panel.bl_space_type, panel.bl_region_type) == ("VIEW_3D", "UI")
        assert panel.bl_category == "Umbilics"


def test_every_setting_can_be_reached(addon, draw):
    settings = bpy.context.scene.umbilics
    reached = set()
    for method in "SIC":
        settings.method = method
        for curvature in ("jets", "normals", "given"):
            settings.curvature = curvature
            for automatic in (True, False):
                settings.scale_auto = settings.persistence_auto = automatic
                settings.crease_angle_auto = automatic
                settings.opening = 0 if automatic else 2
                reached.update(draw().names("prop"))
    assert {p.identifier for p in settings.bl_rna.properties} - {"rna_type", "name"} <= reached


def test_only_what_the_method_reads_is_shown(draw):
    settings = bpy.context.scene.umbilics
    for method, shown, hidden in (
        ("S", "parametrization", "charts"),
        ("C", "charts", "parametrization"),
    ):
        settings.method = method
        names = draw().names("prop")
        assert shown in names
        assert hidden not in names


def test_result_is_shown_once_there_is_one(draw):
    assert "Index sum" not in draw().names("label")
    obj = add_ellipsoid(subdivisions=4)
    bpy.ops.umbilics.detect()
    labels = draw().names("label")
    assert labels[labels.index("Lemons") + 1] == "4"
    assert labels[labels.index("Index sum") + 1] == "2"
    obj.umbilics.warnings.add().text = "A long warning that has to be broken " * 3
    lines = [label for label in draw().names("label") if "warning" in label or "broken" in label]
    assert len(lines) > 1
    bpy.ops.umbilics.clear()
    assert "Index sum" not in draw().names("label")


def test_what_auto_has_chosen_is_said(addon, draw):
    obj = add_ellipsoid(subdivisions=4)
    bpy.ops.umbilics.detect()
    mine = obj.umbilics
    multiple = addon.core.noise_multiple(mine.candidates)
    assert mine.noise_multiple == pytest.approx(multiple)
    assert f"None below {multiple:.1f} × noise" in draw().names("label")
    mine.persistence_level = 0.123
    labels = draw().names("label")
    assert f"Dropped up to {multiple:.1f} × noise (0.12)" in labels
    assert labels[labels.index("Strongest dropped") + 1] == "0.123 1/m"
    bpy.context.scene.umbilics.persistence = 0.01
    bpy.context.scene.umbilics.persistence_auto = False
    labels = draw().names("label")
    assert not any("× noise" in label for label in labels)
    assert f"4 of {mine.candidates} kept" in labels
    assert labels[labels.index("Dropped below") + 1] == "0.01 1/m"


def test_every_number_of_the_statistics_explains_itself(addon, draw):
    add_ellipsoid(subdivisions=3)
    bpy.ops.umbilics.detect()
    explain = addon.operators.explain.UMBILICS_OT_explain
    numbers = draw().names("number")
    assert {"candidates", "index_sum", "noise", "scale", "trust_ratio"} <= set(numbers)
    for number in numbers:
        words = explain.description(bpy.context, SimpleNamespace(number=number))
        assert len(words) > 40, number


def test_a_click_on_a_number_opens_its_chapter_of_the_manual(addon, monkeypatch):
    opened = []
    monkeypatch.setattr(webbrowser, "open", lambda url, *_, **__: opened.append(url))
    for number, chapter in (("noise", "statistics"), ("noise_multiple", "thinning-out")):
        assert bpy.ops.umbilics.explain(number=number) == {"FINISHED"}
        assert opened.pop().endswith(f"guide.html#{chapter}")


def test_running_detection_can_be_watched_and_cancelled(addon, draw):
    obj = add_ellipsoid(subdivisions=4)
    engine, running = addon.operators.jobs.detect, addon.operators.jobs.worker
    running.begin(engine.gather(obj, addon.core.Settings()))
    try:
        paper = draw()
        assert len(paper.names("progress")) == 1
        assert "umbilics.cancel" in paper.names("operator")
        assert "umbilics.detect" not in paper.names("operator")
    finally:
        running.end()
    assert paper.names("operator") != draw().names("operator")


def test_why_nothing_can_be_detected_stands_below_the_button(addon, draw):
    def said():
        return " ".join(draw().names("label"))

    assert "There is no active object. Click a mesh first." in said()
    bpy.ops.object.text_add()
    assert "convert it: Object > Convert > Mesh." in said()
    bpy.ops.object.armature_add()
    assert "Choose the mesh that the armature moves" in said()
    obj = add_ellipsoid(subdivisions=2)
    before = said()
    bpy.ops.object.mode_set(mode="SCULPT")
    assert addon.operators.jobs.refusals.SCULPTED in said()
    bpy.ops.object.mode_set(mode="OBJECT")
    assert said() == before and obj.name not in before
    # What can be detected of several is: then nothing is in the way.
    bpy.ops.object.text_add()
    obj.select_set(True)
    assert not bpy.ops.umbilics.detect.poll() or "convert it" not in said()


def test_what_is_too_much_for_list_and_empties_is_said(addon, draw, monkeypatch):
    obj = add_ellipsoid(subdivisions=4)
    preferences = bpy.context.preferences.addons["bl_ext.user_default.umbilics"].preferences
    monkeypatch.setattr(addon.operators.data.summary, "MOST_ITEMS", 1)
    preferences.most_empties = 3
    try:
        bpy.ops.umbilics.detect()
        said = " ".join(draw().names("label"))
        assert "and 3 less persistent ones" in said
        assert "1 less persistent umbilics have no empty" in said
        bpy.context.scene.umbilics_display.empties = False
        assert "have no empty" not in " ".join(draw().names("label"))
        preferences.most_empties = 4
        bpy.context.scene.umbilics_display.empties = True
        assert "have no empty" not in " ".join(draw().names("label"))
    finally:
        preferences.property_unset("most_empties")
    assert len(obj.umbilics.items) == 1


def test_dropped_umbilics_are_offered_where_something_is_dropped(draw):
    add_ellipsoid(subdivisions=3)
    bpy.ops.umbilics.detect()
    assert "dropped" not in draw().names("prop")
    bpy.context.scene.umbilics_display.opened = True
    assert "dropped" in draw().names("prop")


def test_pole_table_follows_what_the_user_does(addon, draw):
    obj = add_ellipsoid(subdivisions=4)
    assert ("list", "poles") not in draw().drawn
    bpy.ops.umbilics.guide()
    paper = draw()
    assert ("list", "poles") in paper.drawn
    labels = paper.names("label")
    assert labels[labels.index("Sum of 4 - valence") + 1] == "8 of 8"
    assert rows_of(addon, obj)[0][0] == "3"
    assert rows_of(addon, obj)[0][1].startswith("Lemon")
    moved, gone = obj.umbilics_plan.poles[0], obj.umbilics_plan.poles[1]
    bpy.data.objects[moved.name].location.x += 0.1
    bpy.data.objects.remove(bpy.data.objects[gone.name])
    labels = draw().names("label")
    assert labels[labels.index("Sum of 4 - valence") + 1] == "7 of 8"
    assert "moved, added or deleted by hand" in " ".join(labels)
    texts = [row[1] for row in rows_of(addon, obj)]
    assert texts[0].endswith(", moved") and texts[1].endswith(", deleted")
    assert not any("," in text for text in texts[2:])


def rows_of(addon, obj):
    """The labels of each row of the table of poles."""
    table = addon.ui.retopology.UMBILICS_UL_poles
    plan, found = obj.umbilics_plan, []
    for item in plan.poles:
        paper = Paper()
        table.draw_item(None, bpy.context, paper, plan, item, 0, plan, "active")
        found.append(paper.names("label"))
    return found


def test_plan_of_an_edited_mesh_says_so(draw):
    obj = add_ellipsoid(subdivisions=4)
    bpy.ops.umbilics.guide()
    assert "out of date" not in " ".join(draw().names("label"))
    obj.data.vertices[0].co *= 1.2
    obj.data.update()
    bpy.context.view_layer.update()
    told = " ".join(draw().names("label"))
    assert "Plan out of date." in told
    assert "moved" in told


def test_what_quads_could_not_have_stays_readable_below_the_button(draw):
    obj = add_ellipsoid(subdivisions=3)
    # A speck beside it, of which the remesher warns.
    bpy.ops.mesh.primitive_circle_add(vertices=3, radius=0.01, fill_type="NGON")
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.join()
    obj.name = "An ellipsoid, with a name longer than the sidebar is wide"
    bpy.ops.umbilics.remesh_to_quads(quads=100)
    made = bpy.context.object
    warnings = made.umbilics_check.warnings.split("\n")
    assert warnings and all(warnings)
    labels = draw().names("label")
    told = " ".join(labels)
    sentences = (*warnings, f"Against {obj.name}", "8 of 8 planned poles, 0 missing, 0 extra")
    assert all(sentence in told for sentence in sentences)
    # A label that is wider than the sidebar would be cut short.
    assert not any(sentence in one for sentence in sentences for one in labels)
    bpy.ops.umbilics.check_topology()
    assert made.umbilics_check.warnings == ""


def test_edges_can_be_marked_as_seams_as_sharp_and_as_creases(draw):
    assert draw().names("operator").count("umbilics.mark_seams") == 3


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (0.0123, "0.01"),
        (0.00123, "0.0012"),
        (-1.234, "-1.23"),
        (9.96, "10"),
        (112.048, "112"),
        (999.6, "1.0k"),
        (-12345.0, "-12k"),
        (3.4e6, "3.4M"),
        (2e12, "2e12"),
        (-1e-7, "-1e-7"),
    ],
)
def test_numbers_of_the_list_fit_their_columns(addon, value, text):
    assert addon.ui.parts.short(value) == text
    assert len(text) <= 6
