"""What a layer of USD says of itself, in files that Pixar's own library writes."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

import core


@pytest.fixture
def written(tmp_path):
    """Writes a stage with so many prims; its path."""
    usd = pytest.importorskip("pxr.Usd", reason="usd-core is not here; tools/test installs it")
    from pxr import UsdGeom, UsdUtils

    def write(suffix, up, prims):
        layer = "usdc" if suffix == "usdz" else suffix
        path = tmp_path / f"m.{layer}"
        stage = usd.Stage.CreateNew(str(path))
        if up:
            UsdGeom.SetStageUpAxis(stage, up)
        for number in range(prims):
            points = UsdGeom.Points.Define(stage, f"/Z/upAxis/p{number * 7919 % 1000}_{number}")
            points.CreatePointsAttr([(0, 0, number)])
        stage.GetRootLayer().Save()
        if suffix == "usdz":
            path = tmp_path / "m.usdz"
            assert UsdUtils.CreateNewUsdzPackage(str(tmp_path / "m.usdc"), str(path))
        return path

    return write


@pytest.mark.parametrize("prims", [0, 3, 2000])
@pytest.mark.parametrize("up", ["Y", "Z", None])
@pytest.mark.parametrize("suffix", ["usda", "usdc", "usdz"])
def test_the_axis_is_the_one_that_was_written(written, suffix, up, prims):
    assert core.up_axis(written(suffix, up, prims)) == (up or "Y")


@pytest.mark.parametrize("suffix", ["usda", "usdc"])
def test_the_layers_that_one_is_made_of_are_named(tmp_path, suffix):
    usd = pytest.importorskip("pxr.Usd", reason="usd-core is not here; tools/test installs it")
    names = ["./a.usdc", "sub folder/\u00fc.usd", "b.usda", "c.usdc"]
    for name in names:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        part = usd.Stage.CreateNew(str(tmp_path / name))
        part.SetDefaultPrim(part.DefinePrim("/Egg"))
        part.Save()
    stage = usd.Stage.CreateNew(str(tmp_path / f"top.{suffix}"))
    stage.GetRootLayer().subLayerPaths.append(names[0])
    stage.DefinePrim("/T").GetReferences().AddReference(names[1])
    stage.DefinePrim("/P").GetPayloads().AddPayload(names[2])
    variants = stage.DefinePrim("/V").GetVariantSets().AddVariantSet("kind")
    variants.AddVariant("one")
    variants.SetVariantSelection("one")
    with variants.GetVariantEditContext():
        stage.GetPrimAtPath("/V").GetReferences().AddReference(names[3])
    stage.Save()
    assert set(names) <= set(core.usd_names(tmp_path / f"top.{suffix}"))


def test_our_own_files(tmp_path):
    for up in ("Y", "Z"):
        core.write_usda(tmp_path / "o.usda", [], up)
        assert core.up_axis(tmp_path / "o.usda") == up


def test_a_word_of_it_further_down_does_not_count(tmp_path):
    path = tmp_path / "m.usda"
    path.write_text('#usda 1.0\n\ndef Xform "a" {\n    custom token x = "y"\n upAxis = "Z"\n}\n')
    assert core.up_axis(path) == "Y"


def test_a_damaged_file_is_an_error_of_the_format(written, tmp_path):
    data = written("usdc", "Z", 50).read_bytes()
    for number, cut in enumerate((20, len(data) // 2, len(data) - 20)):
        path = tmp_path / f"cut{number}.usdc"
        path.write_bytes(data[:cut])
        with pytest.raises(core.FormatError, match="damaged"):
            core.up_axis(path)
    with pytest.raises(core.FormatError, match="cannot be read"):
        core.up_axis(tmp_path / "none.usdc")


@given(st.binary(max_size=300), st.sampled_from([b"PXR-USDC\0\x08\0", b"PK\3\4", b"#usda 1.0\n"]))
def test_any_bytes_give_an_axis_or_an_error_of_the_format(tmp_path_factory, data, head):
    path = tmp_path_factory.mktemp("usd") / "m.usd"
    path.write_bytes(head + data)
    try:
        assert core.up_axis(path) in ("Y", "Z")
    except core.FormatError as error:
        assert str(error)
