import numpy as np
import pytest

from radiosity.scene.model import SceneError
from radiosity.scene.toml import read_toml
from radiosity.scene.wavefront.obj import read_obj

SQUARE = "[[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]]"
FLOOR = f'[[geometry]]\nmaterial = "m"\npolygons = [{SQUARE}]\n'
TWO_GROUPS = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\ng a\nusemtl m\nf 1 2 3\ng b\nusemtl n\nf 1 3 4\n"
PLAIN = (
    FLOOR + "[materials.m]\ndiffuse = 0.5\n[cameras.c]\nposition = [0, 0, 5]\ntarget = [0, 1, 0]\n"
)


def geometry_file(name, uv):
    if name == "two.obj":
        return read_obj(TWO_GROUPS, name, None, uv=uv)
    if name == "bad.obj":
        raise SceneError(name, ["line 3: one", "line 7: two"])
    raise SceneError(name, ["does not exist"])


def read(text):
    return read_toml(text, "x.toml", geometry_file, "x")


def problems(text):
    with pytest.raises(SceneError) as error:
        read(text)
    assert error.value.source == "x.toml"
    assert str(error.value).splitlines()[0] == f"x.toml: {error.value.problems[0]}"
    return error.value.problems


def material(text):
    return FLOOR + "[materials.m]\n" + text


def camera(text, position="[0, 0, 5]", target="[0, 0, 0]"):
    return PLAIN.split("[cameras")[0] + (
        f"[cameras.c]\nposition = {position}\ntarget = {target}\n{text}\n"
    )


def truth(text):
    return PLAIN + "[truth]\nradiosity = 1\nrelative_tolerance = 0.1\n" + text


# --- what a right file gives -----------------------------------------------------------------


def test_plain_scene_needs_no_notes():
    scene = read(PLAIN)
    assert scene.notes == ()
    assert (scene.name, scene.unit, scene.unit_m, scene.up) == ("x", "m", 1.0, "z")
    assert scene.source == "x.toml"
    assert scene.groups == ("m",)
    assert scene.truth is None
    np.testing.assert_array_equal(scene.faces.vertices[0, 2], [2, 1, 0])
    view = scene.cameras["c"]
    assert (view.name, view.fov, view.size) == ("c", 40.0, (512, 512))
    np.testing.assert_array_equal(view.up, [0, 0, 1])


@pytest.mark.parametrize(
    ("unit", "metres"), [("m", 1), ("cm", 0.01), ("mm", 0.001), ("in", 0.0254), ("ft", 0.3048)]
)
def test_units_and_lengths_stay_in_them(unit, metres):
    scene = read(f'name = "N"\nunit = "{unit}"\nup = "y"\n' + PLAIN)
    assert (scene.name, scene.unit_m, scene.up) == ("N", metres, "y")
    assert scene.faces.areas() == pytest.approx([2])


def test_material_keys():
    made = read(
        material(
            "diffuse = [0.1, 0.2, 0.3]\ntwo_sided = false\n"
            'specular = { model = "phong", reflectance = 0.7, exponent = 50 }\n'
        )
    ).materials[0]
    np.testing.assert_allclose(made.diffuse, [0.1, 0.2, 0.3])
    np.testing.assert_allclose(made.absorptance, [0.9, 0.8, 0.7])
    np.testing.assert_array_equal(made.specular.reflectance, [0.7] * 3)
    assert (made.specular.exponent, made.two_sided, made.emits) == (50, False, False)


def test_absorptance_keeps_what_the_reflectance_would_round_away():
    made = read(material("absorptance = 1e-20")).materials[0]
    np.testing.assert_array_equal(made.absorptance, [1e-20] * 3)
    np.testing.assert_array_equal(made.diffuse, [1.0] * 3)


@pytest.mark.parametrize(
    ("emission", "radiance"),
    [
        ("radiance = [17, 12, 4]", [17, 12, 4]),
        ("radiance = 2", [2, 2, 2]),
        ("exitance = [3, 2, 1]", np.array([3, 2, 1]) / np.pi),
        ("luminance = 1366", [2, 2, 2]),
        ("radiant_flux = 60", [60 / (np.pi * 2e-4)] * 3),
        ("radiant_flux = [60, 0, 6]", np.array([60, 0, 6]) / (np.pi * 2e-4)),
        ("luminous_flux = 683", [1 / (np.pi * 2e-4)] * 3),
    ],
)
def test_emission_in_each_quantity(emission, radiance):
    """The floor has 2 cm2 = 2e-4 m2."""
    made = read('unit = "cm"\n' + material(f"emission = {{ {emission} }}")).materials[0]
    np.testing.assert_allclose(made.emission, radiance, rtol=1e-14)


def test_flux_is_shared_by_all_faces_of_the_material():
    above = FLOOR + "translate = [0, 0, 1]\n"
    made = read(above + material("emission = { radiant_flux = 60 }")).materials[0]
    np.testing.assert_allclose(made.emission, 60 / (np.pi * 4))


def test_reflectance_of_one_is_left_to_the_solver():
    assert read(material("diffuse = 1")).materials[0].diffuse.tolist() == [1, 1, 1]
    sums = 'diffuse = 0.9\nspecular = { model = "phong", reflectance = 0.1, exponent = 1 }'
    assert read(material(sums)).materials[0].specular is not None


def test_materials_that_are_not_defined_or_not_used_are_noted():
    notes = read(
        '[[geometry]]\nfile = "two.obj"\n[materials.nn]\n[materials.m]\ndiffuse = 0\n'
    ).notes
    assert any('material "n": not defined, reflects 0.5' in n for n in notes)
    assert any('material "nn" is defined but no face has it' in n for n in notes)
    assert any('material "nn" gives no diffuse: 0.5 is taken' in n for n in notes)
    assert not any('"m"' in n for n in notes)
    scene = read('[[geometry]]\nfile = "two.obj"\n[materials.nn]\n[materials.m]\ndiffuse = 0\n')
    assert [m.name for m in scene.materials] == ["nn", "m", "n"]
    assert scene.faces.material.tolist() == [1, 2]


def test_gloss_alone_has_no_diffuse_part():
    scene = read(material('specular = { model = "phong", reflectance = 0.9, exponent = 9 }'))
    assert scene.materials[0].diffuse.tolist() == [0, 0, 0]
    assert 'material "m" gives no diffuse: 0 is taken' in scene.notes


def test_groups_come_from_the_file_or_the_material_and_stay_apart():
    above = FLOOR + "translate = [0, 0, 1]\n"
    scene = read('[[geometry]]\nfile = "two.obj"\n' + FLOOR + above + FLOOR.replace('"m"', '"b"'))
    assert scene.groups == ("a", "b", "m", "m-2", "b-2")
    assert scene.faces.group.tolist() == [0, 1, 2, 3, 4]


def test_material_of_a_block_replaces_those_of_the_file():
    scene = read('[[geometry]]\nfile = "two.obj"\nmaterial = "q"\n[materials.q]\ndiffuse = 0.1\n')
    assert [m.name for m in scene.materials] == ["q"]
    assert scene.faces.material.tolist() == [0, 0]
    assert scene.groups == ("a", "b")


def test_concave_polygon_covers_its_area():
    outline = "[[0,0,0],[2,0,0],[2,1,0],[1,1,0],[1,2,0],[0,2,0]]"
    scene = read(FLOOR.replace(SQUARE, outline))
    assert scene.faces.areas().sum() == pytest.approx(3)
    np.testing.assert_allclose(scene.faces.normals(), [[0, 0, 1]] * len(scene.faces))


@pytest.mark.parametrize(
    ("keys", "point"),
    [
        ("translate = [1, 2, 3]", [3, 3, 3]),
        ("scale = 2", [4, 2, 0]),
        ("scale = [2, 3, 1]", [4, 3, 0]),
        ("rotate = [90, 0, 0]", [2, 0, 1]),
        ("rotate = [0, 90, 0]", [0, 1, -2]),
        ("rotate = [0, 0, 90]", [-1, 2, 0]),
        ("rotate = [90, 0, 90]", [0, 2, 1]),  # x first
        ("scale = 2\nrotate = [0, 0, 90]\ntranslate = [10, 0, 0]", [8, 4, 0]),
        ("transform = [[0,-1,0,5],[1,0,0,6],[0,0,1,7],[0,0,0,1]]", [4, 8, 7]),
    ],
)
def test_geometry_is_placed(keys, point):
    """Where the corner (2, 1, 0) goes."""
    vertices = read(FLOOR + keys).faces.vertices
    np.testing.assert_allclose(vertices[0, 2], point, atol=1e-14)


@pytest.mark.parametrize("outline", [SQUARE, "[[0, 0, 0], [2, 0, 0], [2, 1, 0]]"])
def test_reflection_keeps_the_front_the_front(outline):
    """The front looks up; mirrored in x it still does, mirrored in z it looks down."""
    for scale, z in (("[-1, 1, 1]", 1), ("[1, 1, -1]", -1), ("[-1, -1, 1]", 1)):
        faces = read(FLOOR.replace(SQUARE, outline) + f"scale = {scale}").faces
        np.testing.assert_allclose(faces.normals(), [[0, 0, z]], atol=1e-15)
        assert faces.is_triangle[0] == (outline != SQUARE)


def test_an_orthographic_camera_has_a_height_and_no_fov():
    view = read(camera('projection = "orthographic"\nheight = 2.5')).cameras["c"]
    assert view.orthographic and (view.height, view.fov) == (2.5, None)
    plain = read(camera('projection = "pinhole"')).cameras["c"]
    assert not plain.orthographic and (plain.height, plain.fov) == (None, 40.0)


@pytest.mark.parametrize("up", "xyz")
def test_scene_without_a_camera_gets_one_that_looks_at_its_centre(up):
    scene = read(f'up = "{up}"\n' + material("diffuse = 0"))
    view = scene.cameras["default"]
    np.testing.assert_allclose(view.target, [1, 0.5, 0])
    assert view.up.tolist() == [float(a == up) for a in "xyz"]
    assert view.position["xyz".index(up)] > 0
    assert (view.fov, view.size) == (40, (512, 512))
    assert "no camera is given: one outside looks at the whole scene" in scene.notes


def test_camera_that_looks_along_the_default_up_gets_another():
    view = read(camera("")).cameras["c"]
    assert view.up.tolist() == [0, 1, 0]


def test_truth_of_all_of_bands_and_by_name():
    assert read(truth("")).truth.radiosity[""].tolist() == [1, 1, 1]
    assert read(truth("")).truth.mesh == "auto"
    text = PLAIN + (
        '[[geometry]]\nfile = "two.obj"\n[truth]\nmesh = 4\nrelative_tolerance = 1e-3\n'
        "radiosity = { m = 1, a = [1, 2, 3] }\n"
    )
    found = read(text).truth
    assert (found.mesh, found.relative_tolerance) == ("4", 1e-3)
    assert {k: v.tolist() for k, v in found.radiosity.items()} == {"m": [1, 1, 1], "a": [1, 2, 3]}


# --- what a wrong file is told: where, value, bound, way out -----------------------------------

RECEIVES = "a surface cannot reflect more than it receives"
WRONG = [
    # materials
    (material("diffuse = [1.2, 0, 0]"),
     f"materials.m.diffuse[0] = 1.2 must lie in [0, 1]: {RECEIVES}"),
    (material("diffuse = -0.1"), "materials.m.diffuse = -0.1 must lie in [0, 1]"),
    (material("diffuse = nan"), "materials.m.diffuse = nan must be a finite number"),
    (material("diffuse = [0, inf, 0]"), "materials.m.diffuse[1] = inf must be a finite number"),
    (material("diffuse = [0, 0]"), "materials.m.diffuse = [0, 0] must be a number or [r, g, b]"),
    (material('diffuse = "white"'), 'materials.m.diffuse = "white" must be a number or [r, g, b]'),
    (material("diffuse = true"), "materials.m.diffuse = true must be a number or [r, g, b]"),
    (material('diffuse = [0, "1", 0]'), 'materials.m.diffuse[1] = "1" must be a number'),
    (material("diffuse = [0, true, 0]"), "materials.m.diffuse[1] = true must be a number"),
    (material("absorptance = 2"), "materials.m.absorptance = 2 must lie in [0, 1]"),
    (material("diffuse = 0.5\nabsorptance = 0.5"),
     "materials.m gives both diffuse and absorptance: give one"),
    (material("emissivity = 0.8"),
     "materials.m.emissivity is not a known key here: a grey surface of emissivity e has diffuse"),
    (material("emission = { temperature = 500 }"), "temperature is not a known key here: a grey"),
    (material("difuse = 0.5"), "materials.m.difuse is not a known key here: did you mean diffuse?"),
    (material("zzz = 0.5"), "materials.m.zzz is not a known key here: known are diffuse, absorpt"),
    (material("two_sided = 1"), "materials.m.two_sided = 1 must be true or false"),
    (material("specular = 0.5"), "materials.m.specular = 0.5 must be a table of keys"),
    (material('specular = { model = "phong", reflectance = 0.5 }'),
     "materials.m.specular.exponent is missing: 0 is as wide as diffuse"),
    (material('specular = { model = "ward", reflectance = 0.5, exponent = 1 }'),
     "materials.m.specular.model = \"ward\" must be one of 'phong', 'blinn' or 'torrance-sparrow'"),
    (material('specular = { model = "phong", reflectance = 0.5, exponent = -1 }'),
     "materials.m.specular.exponent = -1 must be at least 0"),
    (material('specular = { model = "phong", reflectance = 1.5, exponent = 1 }'),
     "materials.m.specular.reflectance = 1.5 must lie in [0, 1]"),
    (material('specular = { model = "phong", reflectance = 0.5, exponent = 1, shine = 1 }'),
     "materials.m.specular.shine is not a known key here: known are model, reflectance, exponent"),
    (material('diffuse = [0, 0.8, 0]\n'
              'specular = { model = "phong", reflectance = 0.3, exponent = 1 }'),
     "materials.m: diffuse + specular = 1.1 at 0 degrees in band g must be at most 1"),
    (material('absorptance = 0.1\nspecular = { model = "phong", reflectance = 0.3, exponent = 1 }'),
     "materials.m: diffuse + specular = 1.2 at 0 degrees in band r must be at most 1"),
    (material("emission = { radiance = 1, exitance = 2 }"),
     "materials.m.emission gives radiance and exitance: give one of radiance, exitance, luminance"),
    (material("emission = {}"), "materials.m.emission gives nothing: give one of radiance"),
    (material("emission = { radiance = [1, -1, 0] }"),
     "materials.m.emission.radiance[1] = -1 must be at least 0: light cannot be taken away"),
    (material("emission = { luminance = [1, 1, 1] }"),
     "materials.m.emission.luminance = [1, 1, 1] must be a number"),
    (material("emission = { lumens = 1 }"), "materials.m.emission.lumens is not a known key here"),
    (material("emission = 5"), "materials.m.emission = 5 must be a table of keys"),
    (FLOOR + "materials = 5", "geometry[0].materials is not a known key here"),
    ("materials = 5\n" + FLOOR, "materials = 5 must be a table: write [materials]"),
    (FLOOR + '[materials."my wall"]\ndiffuse = 2', 'materials."my wall".diffuse = 2 must lie'),
    (FLOOR + "[materials]\nm = 3", "materials.m = 3 must be a table of keys"),
    # geometry
    ("", "geometry is missing: a scene needs at least one [[geometry]]"),
    ('name = "x"\n[geometry]\nfile = "two.obj"',
     'geometry = { file = "two.obj" } must be a list of tables: write [[geometry]]'),
    ('[[geometry]]\nmaterial = "m"',
     "geometry[0] gives neither file nor polygons: give either file"),
    (f'[[geometry]]\nfile = "two.obj"\npolygons = [{SQUARE}]',
     "geometry[0] gives file and polygons: give either"),
    (PLAIN + '[[geometry]]\nfile = "gone.obj"', 'geometry[1].file = "gone.obj" does not exist'),
    (PLAIN + '[[geometry]]\nfile = 3', "geometry[1].file = 3 must be text in quotes"),
    (FLOOR.replace("[2, 1, 0]", "[2, nan, 0]"),
     "geometry[0].polygons[0][2][1] = nan must be a finite number"),
    (FLOOR.replace("[2, 1, 0]", "[2, 1e31, 0]"),
     "geometry[0].polygons[0][2][1] = 1e+31 must lie in [-1e+30, 1e+30]"),
    (FLOOR.replace("[2, 1, 0]", "[2, 1]"),
     "geometry[0].polygons[0][2] = [2, 1] must be three numbers [x, y, z]"),
    (FLOOR.replace(SQUARE, "[1]"),
     "geometry[0].polygons[0][0] = 1 must be three numbers"),
    (FLOOR.replace(f"[{SQUARE}]", "5"), "geometry[0].polygons = 5 must be a list of polygons"),
    (FLOOR.replace(SQUARE, ""), "geometry[0].polygons is empty: list at least one polygon"),
    (FLOOR.replace(SQUARE, "[[0,0,0],[1,0,0]]"),
     "geometry[0].polygons[0] has 2 vertices, a polygon needs at least 3"),
    (FLOOR.replace(SQUARE, "[]"), "geometry[0].polygons[0] has 0 vertices"),
    (FLOOR.replace(SQUARE, SQUARE + ", [[0,0,0],[1,0,0],[1,1,0.1],[0,1,0],[-1,0.5,0]]"),
     "geometry[0].polygons[1] is not planar: vertex"),
    (FLOOR.replace(SQUARE, "[[0,0,0],[1,1,0],[1,0,0],[0,1,0]]"),
     "geometry[0].polygons[0] crosses itself: edge 0"),
    (FLOOR.replace(SQUARE, "[[0,0,0],[1,1,0],[2,2,0]]"), "geometry[0].polygons[0] has no area"),
    (FLOOR + "translate = [0, 0]", "geometry[0].translate = [0, 0] must be three numbers"),
    (FLOOR + "scale = 0", "geometry[0].scale = 0 must not flatten the geometry to a plane"),
    (FLOOR + "scale = [1, 0, 1]", "geometry[0].scale = [1, 0, 1] must not flatten"),
    (FLOOR + "transform = [[1,0,0,0],[0,1,0,0],[0,0,1,0]]",
     "geometry[0].transform = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]] must be four rows"),
    (FLOOR + "transform = [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,1,1]]",
     "geometry[0].transform[3] = [0.0, 0.0, 1.0, 1.0] must be [0, 0, 0, 1]"),
    (FLOOR + "transform = [[1,0,0,0],[0,1,0,0],[0,0,0,0],[0,0,0,1]]", "must not flatten"),
    (FLOOR + "transform = [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]\nscale = 2",
     "geometry[0] gives transform and scale: give one or the other"),
    (FLOOR + "scale = 1e30\ntranslate = [1e30, 0, 0]",
     "geometry: a vertex lies 3e+30 from the origin, at most 1e+30"),
    (FLOOR + "scale = 1e-200", "geometry: a face is too small for its area to be computed"),
    # the file
    ('unit = "km"\n' + FLOOR, "unit = \"km\" must be one of 'm', 'cm', 'mm', 'in' or 'ft'"),
    ('up = "w"\n' + FLOOR, "up = \"w\" must be one of 'x', 'y' or 'z'"),
    ("name = 5\n" + FLOOR, "name = 5 must be text in quotes"),
    ("nmae = 5\n" + FLOOR, "nmae is not a known key here: did you mean name?"),
    ("[materials.m]\n" + ".".join("a" * 3000) + " = 1\n" + FLOOR, "materials.m.a is not a known"),
    ("[[lamps]]\ntype = \"point\"\n" + FLOOR, "lamps is not a known key here"),
    # cameras
    (camera('projection = "parallel"'),
     "cameras.c.projection = \"parallel\" must be one of 'pinhole' or 'orthographic'"),
    (camera('projection = "orthographic"'),
     "cameras.c.height is missing: the vertical extent that an orthographic camera shows"),
    (camera('projection = "orthographic"\nheight = 2\nfov = 40'),
     "cameras.c.fov = 40 is for pinhole cameras: an orthographic one has height instead"),
    (camera("height = 2"), 'cameras.c.height = 2 needs projection = "orthographic"'),
    (camera('projection = "orthographic"\nheight = 0'),
     "cameras.c.height = 0 must lie between 0 and 1e+30, both excluded: the vertical extent"),
    (camera('projection = "orthographic"\nheigth = 2'), "cameras.c.heigth is not a known key"),
    (camera("fov = 0"), "cameras.c.fov = 0 must lie between 0 and 180, both excluded"),
    (camera("fov = 180"), "cameras.c.fov = 180 must lie between 0 and 180"),
    (camera("size = [0, 5]"), "cameras.c.size = [0, 5] must be [width, height], two whole numbers"),
    (camera("size = [5, 16385]"), "from 1 to 16384"),
    (camera("size = [5, 5.0]"), "cameras.c.size = [5, 5.0] must be [width, height]"),
    (camera("size = 5"), "cameras.c.size = 5 must be [width, height]"),
    (camera("size = [true, 5]"), "cameras.c.size = [true, 5] must be"),
    (camera("", target="[0, 0, 5]"),
     "cameras.c looks from [0.0, 0.0, 5.0] at the same point: move its target"),
    (camera("up = [0, 0, -2]"),
     "cameras.c.up = [0.0, 0.0, -2.0] must not be parallel to the view from position to target"),
    (camera("up = [0, 0, 0]"), "cameras.c.up = [0.0, 0.0, 0.0] must not be zero"),
    (camera("", position="[0, inf, 0]"), "cameras.c.position[1] = inf must be a finite number"),
    (PLAIN.split("target")[0], "cameras.c.target is missing: the point the camera looks at"),
    # truth
    (truth("mesh = 0"), 'truth.mesh = 0 must be "auto", "input" or a whole number of cells'),
    (truth("mesh = true"), "truth.mesh = true must be"),
    (truth("tolerance = 1"), "truth.tolerance is not a known key here: did you mean relative_tol"),
    (PLAIN + "[truth]\nradiosity = 1", "truth.relative_tolerance is missing: how far"),
    (PLAIN + "[truth]\nrelative_tolerance = 1", "truth.radiosity is missing: the known answer"),
    (PLAIN + "[truth]\nradiosity = -1\nrelative_tolerance = 1",
     "truth.radiosity = -1 must be at least 0"),
    (PLAIN + "[truth]\nradiosity = 1\nrelative_tolerance = 0",
     "truth.relative_tolerance = 0 must be greater than 0"),
    (PLAIN + "[truth]\nradiosity = {mm = 1}\nrelative_tolerance = 1",
     "truth.radiosity.mm is neither a material nor a group: did you mean m?"),
    (PLAIN + "[truth]\nradiosity = {m = [1, -1, 2]}\nrelative_tolerance = 1",
     "truth.radiosity.m[1] = -1 must be at least 0"),
    (PLAIN + "[truth]\nradiosity = {}\nrelative_tolerance = 1",
     "truth.radiosity = {  } must name at least one material or group"),
    ("truth = 1\n" + PLAIN, "truth = 1 must be a table"),
    # TOML itself, and numbers that no double holds
    ("name = \n" + FLOOR, "line 1, column 8: Invalid value (this is not valid TOML)"),
    ('a = 1\na = 2\n', "line 2, column 6: Cannot overwrite a value"),
    ("a = [1, 2", "end of document: "),
    ("a = " + "[" * 5000, "arrays or tables are nested too deeply"),
    ("a = " + "9" * 5000, "a number cannot be read"),
    (material("diffuse = 1" + "0" * 400), "must be a finite number"),
    (material("diffuse = 0x" + "f" * 9000), "a whole number of more than 40 digits must be a fin"),
    (material("diffuse = 2024-01-01"), "materials.m.diffuse = 2024-01-01 must be a number or"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "told"), WRONG, ids=[told[:50] for _, told in WRONG])
def test_one_mistake_gives_one_problem_with_where_value_and_bound(text, told):
    found = problems(text)
    assert len(found) == 1, found
    assert told in found[0]


def test_every_problem_of_a_named_file_is_passed_on():
    assert problems('[[geometry]]\nfile = "bad.obj"\n') == [
        'geometry[0].file = "bad.obj" line 3: one',
        'geometry[0].file = "bad.obj" line 7: two',
    ]


def test_all_mistakes_are_reported_at_once():
    text = f"""
unit = "km"
nmae = "x"

[[geometry]]
file = "bad.obj"
translate = [nan, 0, inf]

[[geometry]]
file = "gone.obj"

[[geometry]]
polygons = [{SQUARE}, [[0, 0, 0], [1, 0, 0]], [[0, 0, 0], [1, 1, 1], [2, 2, 2]]]
materiel = "m"
polygon = 1

[materials.a]
diffuse = [1.2, -1, 2]
two_sided = "yes"

[materials.b]
diffuse = 0.8
two_sided = 3
specular = {{ model = "phong", reflectance = 0.4, exponent = -1, gloss = 2 }}
emission = {{ radiance = 1, exitance = -2 }}

[cameras.front]
position = [0, 0, 0]
target = [0, 0, 0]
fov = 200

[truth]
radiosity = [1, "x", -3]
"""
    expected = [
        'unit = "km"',
        "nmae is not",
        "geometry[0].translate[0] = nan",
        "geometry[0].translate[2] = inf",
        'geometry[0].file = "bad.obj" line 3',
        'geometry[0].file = "bad.obj" line 7',
        'geometry[1].file = "gone.obj"',
        "geometry[2].polygons[1] has 2 vertices",
        "geometry[2].polygons[2] has no area",
        "geometry[2].materiel",
        "geometry[2].polygon is",
        "materials.a.diffuse[0] = 1.2",
        "materials.a.diffuse[1] = -1",
        "materials.a.diffuse[2] = 2",
        "materials.a.two_sided",
        "materials.b.two_sided",
        "materials.b.specular.exponent",
        "materials.b.specular.gloss",
        "materials.b: diffuse + specular = 1.2 at 0 degrees",
        "materials.b.emission gives radiance and exitance",
        "materials.b.emission.exitance = -2",
        "cameras.front looks from",
        "cameras.front.fov = 200",
        'truth.radiosity[1] = "x"',
        "truth.radiosity[2] = -3",
        "truth.relative_tolerance is missing",
    ]
    found = problems(text)
    for start in expected:
        assert sum(p.startswith(start) for p in found) == 1, start
    assert len(found) == len(expected)


def test_a_wrong_key_does_not_hide_what_is_wrong_with_the_file_or_the_polygons():
    """Blocks with a wrong key are still read: their other mistakes are told in the same go."""
    text = (
        '[[geometry]]\nfile = "gone.obj"\nscale = "big"\n'
        '[[geometry]]\nmateriel = "m"\npolygons = [[[0, 0, 0], [1, 0, 0]]]\n'
    )
    found = problems(text)
    assert [p.split(" ")[0] for p in found] == [
        "geometry[0].scale", "geometry[0].file", "geometry[1].materiel", "geometry[1].polygons[0]",
    ]  # fmt: skip


def test_truth_and_parts_are_checked_even_where_the_top_is_wrong():
    found = problems(
        "extra = 1\n" + PLAIN + "[truth]\nradiosity = {zz = 1}\nrelative_tolerance = 1"
    )
    assert any("extra is not" in p for p in found)
    assert any("truth.radiosity.zz" in p for p in found)
