"""The window speaks German: names by Blender, sentences by the templates that they were made of."""

import json
import os
import subprocess

import bpy
import numpy as np
import pytest
from scene_building import add_ellipsoid, add_mesh, empty_scene
from test_panel import drawn_panels


@pytest.fixture
def german(addon, known, monkeypatch):
    """Blender in German, with an empty scene; English afterwards.

    A Blender that was built without its languages is stood in for: it looks texts up as the
    other does, in what the add-on gives it.
    """
    empty_scene()
    translation = addon.operators.base.translation
    translation._translated.cache_clear()
    view = bpy.context.preferences.view
    before = view.language
    wanted = [name for name in ("de_DE", "de") if can_speak(view, name)]
    if wanted:
        view.use_translate_interface = view.use_translate_tooltips = True
        view.use_translate_reports = True
    else:

        def look(text):
            return known.get(("*", text), text)

        monkeypatch.setattr(translation, "_language", lambda: "de")
        monkeypatch.setattr(translation, "_label", look)
        monkeypatch.setattr(translation, "_message", look)
    yield addon
    if wanted:
        view.language = before
    translation._translated.cache_clear()


def can_speak(view, language):
    try:
        view.language = language
    except TypeError:
        return False
    return bpy.app.translations.locale.startswith("de")


@pytest.fixture
def known(addon):
    """All texts that there are translations of, by language."""
    return addon.operators.base.translation.languages()["de"]


def ours():
    """The add-on's classes that Blender knows."""
    kinds = bpy.types.Panel, bpy.types.Operator, bpy.types.Menu, bpy.types.PropertyGroup
    kinds += bpy.types.AddonPreferences, bpy.types.UIList
    return [cls for kind in kinds for cls in kind.__subclasses__() if is_ours(cls)]


def is_ours(cls):
    return cls.__module__.startswith("bl_ext.user_default.umbilics") and cls.is_registered


def test_every_name_and_tooltip_that_blender_knows_is_in_german(addon, known):
    texts = {text for _, text in known}
    missing = set()
    for cls in ours():
        for name in ("bl_label", "bl_description"):
            if getattr(cls, name, ""):
                missing.add(getattr(cls, name))
        rna = cls.bl_rna
        shown = [item for item in rna.properties if item.identifier in cls.__annotations__]
        for item in shown:
            if item.name and item.is_runtime and item.name != item.identifier:
                missing |= {item.name, item.description}
            for choice in getattr(item, "enum_items", ()):
                missing |= {choice.name, choice.description}
    missing -= texts | {""}
    assert {text for text in missing if not is_neutral(text)} == set()


def is_neutral(text):
    """Whether a text is the same in every language: letters of axes, signs, names of formats."""
    return len(text) < 4 or text in ("Umbilics", "JSON")


def test_operators_are_in_their_own_context(known):
    assert known["Operator", "Detect Umbilics"] == "Nabelpunkte erkennen"
    assert ("*", "Detect Umbilics") not in known


def test_blender_is_given_them_and_lets_go_of_them(addon):
    """Registering twice is an error of Blender's, as letting go of what is not there is."""
    translation = addon.operators.base.translation
    assert set(translation.languages()) == {"de"}
    translation.unregister()
    translation.register()
    find = bpy.app.translations.pgettext_iface
    if bpy.app.translations.locale.startswith("de"):
        assert find("Detect Umbilics", "Operator") == "Nabelpunkte erkennen"


# What a Blender says whose language is the system's.
_SAYS = """
import bpy, json, sys
# Not every Blender translates its interface from the start.
view = bpy.context.preferences.view
view.use_translate_interface = view.use_translate_tooltips = view.use_translate_reports = True
find = bpy.app.translations
said = {"locale": find.locale, "button": find.pgettext_iface("Detect Umbilics", "Operator")}
said["label"] = find.pgettext_iface("Most Important")
said["tooltip"] = find.pgettext_tip("Which faces are analysed; the others are treated as if they "
                                    "were not there")
made = sys.modules["bl_ext.user_default.umbilics.operators.base.translation"]
said["sentence"] = made.translated("71 umbilics: trust good")
bpy.ops.wm.read_homefile(use_empty=True)
try:
    bpy.ops.umbilics.detect()
except RuntimeError as error:
    said["error"] = str(error)
print("SAYS " + json.dumps(said))
"""


def test_a_blender_in_german_speaks_it_everywhere(known):
    """Not stood in for: Blender takes its language from the system where it can."""
    if not bpy.app.binary_path:
        pytest.skip("Blender as a module is built without languages")
    german = {"LC_ALL": "de_DE.UTF-8", "LANGUAGE": "de_DE"}
    done = subprocess.run(
        [bpy.app.binary_path, "-b", "--python-exit-code", "1", "--python-expr", _SAYS],
        env=os.environ | german,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    lines = [line for line in done.stdout.splitlines() if line.startswith("SAYS ")]
    said = json.loads(lines[0].removeprefix("SAYS "))
    if not said["locale"].startswith("de"):
        pytest.skip("this Blender does not take German from the system")
    assert said["button"] == "Nabelpunkte erkennen"
    assert said["label"] == known["*", "Most Important"]
    assert said["tooltip"].startswith("Welche Flächen")
    assert said["sentence"] == "71 Nabelpunkte: verlässlich"
    assert "Es gibt kein aktives Objekt" in said["error"]


@pytest.mark.parametrize(
    ("english", "german_text"),
    [
        ("no umbilics", "keine Nabelpunkte"),
        ("1 umbilic, 2 regions", "1 Nabelpunkt, 2 Gebiete"),
        (
            "71 umbilics: trust fair: 4 of uncertain kind",
            "71 Nabelpunkte: bedingt verlässlich: 4 von unsicherer Art",
        ),
        (
            "2 umbilics: trust fair: the noise is not small beside the shape",
            "2 Nabelpunkte: bedingt verlässlich: das Rauschen ist nicht klein neben der Form",
        ),
        ("no isolated umbilics, 1 region", "keine einzelnen Nabelpunkte, 1 Gebiet"),
        (
            "8 poles of valence 3 and 0 of valence 5; 4 - valence sums to 8, four times the Euler "
            "characteristic is 8.",
            "8 Pole der Valenz 3 und 0 der Valenz 5; 4 - Valenz summiert sich zu 8, das Vierfache "
            "der Euler-Charakteristik ist 8.",
        ),
        (
            "4 lemons and 2 stars; index sum 2, as the Euler characteristic wants.",
            "4 Zitronen und 2 Sterne; Indexsumme 2, wie es die Euler-Charakteristik verlangt.",
        ),
        ("With Mirror, whole object", "Mit Mirror, ganzes Objekt"),
        (
            "The mesh itself, group Hand; 3 of 10 faces left out",
            "Das Mesh selbst, Gruppe Hand; 3 von 10 Flächen ausgelassen",
        ),
        (
            "Lemon has no faces: curvature needs a surface.",
            "Lemon hat keine Flächen: Krümmung braucht eine Fläche.",
        ),
        (
            "12 triangles with repeated corners left out. 1 edge with three or more triangles: the "
            "sheets that meet there were taken apart, and end at that edge where they do not go "
            "straight on.",
            "12 Dreiecke mit wiederholten Ecken ausgelassen. 1 Kante mit drei oder mehr Dreiecken: "
            "die Blätter, die sich dort treffen, wurden getrennt und enden an dieser Kante, wo sie "
            "nicht geradeaus weitergehen.",
        ),
        ("Changed since: Method, Crease Angle.", "Seitdem geändert: Verfahren, Knickwinkel."),
        ("What nobody has said", "What nobody has said"),
    ],
)
def test_sentences_are_found_by_their_templates(german, english, german_text):
    translation = german.operators.base.translation
    for say in (translation.translated, translation.reported):
        assert say(english) == german_text


def test_in_english_nothing_is_changed(addon):
    say = addon.operators.base.translation.translated
    assert say("1 umbilic, 2 regions") == "1 umbilic, 2 regions"


def test_no_template_is_taken_for_another(german, known):
    """Filled with what stands for nothing, every template finds its own translation."""
    translation = german.operators.base.translation
    wrong = []
    for _, text in known:
        template = translation._template(text)
        if not template.holes or template.words < 4:
            continue
        filled = translation._HOLE.sub(filler, text)
        first = next(one for one in translation._templates("de") if one.looks.fullmatch(filled))
        if translation._HOLE.sub("{}", first.text) != translation._HOLE.sub("{}", text):
            wrong.append((text, first.text))
    assert wrong == []


def filler(hole):
    name = hole[1].rstrip("0123456789")
    return {"count": "7", "several": "7 Xx"}.get(name, "Xx")


def test_panels_draw_in_german(german, known):
    obj = add_ellipsoid(subdivisions=3)
    bpy.ops.umbilics.detect()
    bpy.ops.umbilics.guide()
    bpy.context.scene.umbilics.persistence_auto = False
    obj.umbilics.warnings.add().text = "The mesh has no faces: umbilics need a surface."
    obj.data.vertices[0].co *= 1.01
    obj.data.update()
    bpy.context.view_layer.update()
    labels = drawn_labels(german)
    assert "Sterne" in labels or "Zitronen" in labels
    told = " ".join(labels)
    for words in ("Veraltet.", "Das Mesh wurde bearbeitet", "Das Mesh hat keine Flächen"):
        assert words in told
    english = [text for text in labels if known.get(("*", text), text) != text]
    assert english == []
    unknown = [text for text in labels if is_english(text)]
    assert unknown == []


def drawn_labels(addon):
    return [seen(addon, text) for text in drawn_panels().names("label") if text]


def seen(addon, text):
    """What Blender makes of a label, or a button's text."""
    translation = addon.operators.base.translation
    known = translation.languages()["de"]
    return known.get(("Operator", text), translation._label(text))


def is_english(text):
    words = {word.strip(".,;:()") for word in text.lower().split()}
    return bool(words & {"the", "of", "and", "was", "were", "is", "are", "with", "not", "to"})


def test_errors_are_told_in_german(german):
    add_mesh(np.eye(3), [], name="Leer")
    bpy.context.scene.umbilics_display.source = "BASE"
    with pytest.raises(RuntimeError, match="hat keine Flächen"):
        bpy.ops.umbilics.detect()
