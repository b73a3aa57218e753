"""Photometric files: what LM-63 and EULUMDAT texts say, their symmetries, and what is refused."""

import re

import numpy as np
import pytest

from radiosity.scene.model import SceneError
from radiosity.scene.photometric.eulumdat import read_eulumdat
from radiosity.scene.photometric.ies import read_ies

GAMMA = np.arange(0.0, 181.0, 15.0)


def bumpy(c, gamma):
    """Return an intensity with both symmetries, the same for all C at the poles."""
    sine = np.sin(np.radians(gamma))
    return 50.0 + 40 * np.cos(np.radians(gamma)) + 10 * sine * np.cos(2 * np.radians(c))


def lopsided(c, gamma):
    return bumpy(c, gamma) + 8 * np.sin(np.radians(gamma)) * np.sin(np.radians(c - 20))


def to_c0(c, gamma):
    """Symmetric about C0-C180."""
    return bumpy(c, gamma) + 8 * np.sin(np.radians(gamma)) * np.cos(np.radians(c))


def to_c90(c, gamma):
    """Symmetric about C90-C270."""
    return bumpy(c, gamma) + 8 * np.sin(np.radians(gamma)) * np.sin(np.radians(c))


def table(law, planes, gamma=GAMMA):
    return law(np.asarray(planes)[:, None], np.asarray(gamma)[None])


def ies(planes, values, gamma=GAMMA, head=("IESNA:LM-63-2002",), numbers=None, tilt="TILT=NONE"):
    """Return the text of an LM-63 file."""
    first = numbers or f"1 -1 1 {len(gamma)} {len(planes)} 1 2 0.1 0.2 0 1 1 20"
    rows = [" ".join(f"{v:.9g}" for v in row) for row in (gamma, planes, *values)]
    return "\n".join([*head, tilt, first, *rows]) + "\n"


def ldt(symmetry, planes, values, gamma=GAMMA, *, lorl=100, factor=1, sets=((1, 1000),), tilt=0):
    """Return the text of an EULUMDAT file; intensities in cd/klm."""
    step = planes[1] - planes[0] if len(planes) > 1 else 0
    lines = ["Maker", 1, symmetry, len(planes), step, len(gamma), gamma[1] - gamma[0], "report",
             "Lamp one", "no. 1", "one.ldt", "today", 1200, 300, 80, 1100, 0, 0, 0, 0, 0, 60,
             lorl, factor, tilt, len(sets)]  # fmt: skip
    for count, flux in sets:
        lines += [count, "LED", flux, 4000, 80, 30]
    return "\n".join(map(str, [*lines, *[0.5] * 10, *planes, *gamma, *np.ravel(values)])) + "\n"


def read(text, name="x.ies"):
    return (read_eulumdat if name.endswith("ldt") else read_ies)(text, name)


def at(found, c, gamma):
    shares, peak = found.distribution
    return peak * shares(np.radians(c), np.radians(gamma))


SYMMETRIES = [
    (np.array([0.0]), lambda c, g: bumpy(0 * c + 45, g), "one plane"),
    (np.arange(0, 91, 15.0), bumpy, "four quarters"),
    (np.arange(0, 181, 15.0), to_c0, "about C0-C180"),
    (np.arange(90, 271, 15.0), to_c90, "about C90-C270"),
    (np.arange(0, 360, 15.0), lopsided, "without 360"),
]


@pytest.mark.parametrize("planes, law, name", SYMMETRIES, ids=[s[2] for s in SYMMETRIES])
def test_planes_that_follow_by_symmetry_are_those_of_the_full_lm_63_file(planes, law, name):
    every = np.arange(0, 361, 15.0)
    found, full = read(ies(planes, table(law, planes))), read(ies(every, table(law, every)))
    c, gamma = np.random.default_rng(1).uniform(0, (360, 180), (400, 2)).T
    np.testing.assert_allclose(at(found, c, gamma), at(full, c, gamma), rtol=1e-7)  # 9 digits
    assert found.flux == pytest.approx(full.flux, rel=1e-7)
    expected = law(every[3], GAMMA[4])
    assert at(full, every[3:4], GAMMA[4:5])[0] == pytest.approx(expected, rel=1e-7)


def test_a_half_without_a_plane_at_180_degrees_is_linear_across():
    """C = 0 lies between 340, where the plane of 200 is repeated, and 50, where that of 130 is."""
    found = read(ies([90, 130, 200, 270], [[9, 8], [7, 6], [5, 4], [3, 2]], (0, 90)))
    assert found.planes.tolist() == [0, 50, 90, 130, 200, 270, 340, 360]
    assert found.candela[0].tolist() == pytest.approx([5 + 2 * 20 / 70, 4 + 2 * 20 / 70])
    assert found.candela[1].tolist() == [7, 6] and found.candela[6].tolist() == [5, 4]


LISTED = {  # the planes with values, of all
    0: (np.arange(0, 360, 15.0), lopsided), 1: (np.zeros(1), lambda c, g: bumpy(0 * c + 45, g)),
    2: (np.arange(0, 181, 15.0), to_c0), 3: (np.arange(-90, 91, 15.0), to_c90),
    4: (np.arange(0, 91, 15.0), bumpy),
}  # fmt: skip


@pytest.mark.parametrize("symmetry", LISTED)
def test_planes_that_follow_by_symmetry_are_those_of_the_full_eulumdat_file(symmetry):
    every = np.arange(0, 360, 15.0)
    listed, law = LISTED[symmetry]
    found = read(ldt(symmetry, every, table(law, listed)), "x.ldt")
    full = read(ldt(0, every, table(law, every)), "x.ldt")
    same = read(ies(np.append(every, 360), table(law, np.append(every, 360))))
    c, gamma = np.random.default_rng(1).uniform(0, (360, 180), (400, 2)).T
    np.testing.assert_allclose(at(found, c, gamma), at(full, c, gamma), rtol=1e-12)
    np.testing.assert_allclose(at(found, c, gamma), at(same, c, gamma), rtol=1e-7)  # 9 digits


@pytest.mark.parametrize("gamma", [(0, 45, 90), (90, 120, 180), (0, 90, 180)])
def test_halves_that_are_not_measured_are_dark(gamma):
    found = read(ies([0], [[7, 7, 7]], gamma))
    lit = at(found, np.zeros(3), np.array([10.0, 90, 170]))
    assert lit.tolist() == pytest.approx([7 * (gamma[0] == 0), 7, 7 * (gamma[-1] == 180)])
    assert found.flux == pytest.approx(7 * 2 * np.pi * (gamma[-1] - gamma[0]) / 90, rel=1e-12)


@pytest.mark.parametrize(
    ("head", "format", "factor"),
    [
        ((), "LM-63-1986", 0.72),
        (("Maker's luminaire", "of 1987"), "LM-63-1986", 0.72),
        (("IESNA91", "[MANUFAC] A"), "LM-63-1991", 0.72),
        (("IESNA:LM-63-1995", "[MANUFAC] A"), "LM-63-1995", 0.9),
        (("IESNA:LM-63-2002", "[MANUFAC] A", "[MORE] b"), "LM-63-2002", 0.9),
        (("IES:LM-63-2019", "[MANUFAC] A"), "LM-63-2019", 0.9),
    ],
)
def test_standards_of_all_years_and_their_factors(head, format, factor):
    """Times multiplier and ballast factor; before 1995 a ballast-lamp factor too."""
    numbers = "2 3000 1.5 2 1 1 1 1 2 0.5\n0.9 0.8 60"
    found = read(ies([0], [[100, 50]], (0, 90), head, numbers))
    assert found.format == format
    np.testing.assert_allclose(found.candela[0], np.array([150, 75]) * factor, rtol=1e-12)
    assert found.stated == pytest.approx(6000 * factor)
    assert found.opening == pytest.approx(2 * 0.3048)  # feet
    assert found.maker == ("A" if "[MANUFAC] A" in head else "")
    ignored = [note for note in found.notes if "after the ballast factor" in note]
    assert len(ignored) == (format in ("LM-63-1995", "LM-63-2002"))


def test_numbers_may_stand_in_any_lines_and_be_parted_by_commas():
    plain = read(ies([0, 90], [[9, 8], [7, 6]], (0, 90)))
    text = ies([0, 90], [[9, 8], [7, 6]], (0, 90))
    head, _, numbers = text.partition("NONE\n")
    for joint in ("\n", ", ", "\r\n", ",\n"):
        other = read(head + "NONE\n" + joint.join(numbers.split()) + "\n\x1a")
        np.testing.assert_array_equal(other.candela, plain.candela)
        assert other.notes == plain.notes == () and other.opening == 0.2


def test_the_maker_and_the_luminaire_are_named():
    head = "IESNA:LM-63-2002", "[TEST] 7", "[MANUFAC]  Lamps  & Co ", "[LUMCAT] L-1", "[MORE] x"
    assert read(ies([0], [[9, 8]], (0, 90), head)).label == "x.ies, LM-63-2002: Lamps & Co, L-1"
    old = read(ies([0], [[9, 8]], (0, 90), ("A lamp of 1986", "more of it")))
    assert old.label == "x.ies, LM-63-1986: A lamp of 1986"
    assert read(ldt(1, [0.0], [5.0] * 13), "x.ldt").label == "x.ldt, EULUMDAT: Maker, Lamp one"


def test_tilt_factors_are_read_and_noted():
    tilt = "TILT=INCLUDE\n1\n3\n0 45 90\n1 0.95 0.9"
    found = read(ies([0], [[9, 8]], (0, 90), tilt=tilt))
    assert found.candela[0].tolist() == [9, 8]
    assert found.notes == (
        "factors for a tilted lamp, from 0.9 to 1, are not applied: luminous_flux of the scene can "
        "be lowered by them",
    )
    assert read(ies([0], [[9, 8]], (0, 90), tilt=tilt.replace("0.95 0.9", "1 1"))).notes == ()
    other = read(ies([0], [[9, 8]], (0, 90), tilt="TILT=LAMP.TLT"))
    assert other.notes == ("factors for a tilted lamp, in the file 'LAMP.TLT', are not read",)


def relative(lumens):
    """Return a Lambertian luminaire of pi * 1000 lm whose lamps have some lumens."""
    gamma = np.arange(0, 91, 1.0)
    numbers = f"1 {lumens} 1 91 1 1 2 0 0 0 1 1 20"
    found = read(ies([0], [1000 * np.cos(np.radians(gamma))], gamma, numbers=numbers))
    assert found.flux == pytest.approx(1000 * np.pi, rel=5e-5)
    return found


def test_lm_63_states_the_flux_of_the_lamps():
    assert relative(-1).label == "x.ies, LM-63-2002" and relative(-1).stated is None
    assert relative(4000).label == "x.ies, LM-63-2002 (79% of the 4000 lm of its lamps)"
    assert relative(-1).notes == relative(3141.6).notes == relative(4000).notes == ()
    (told,) = relative(2800).notes
    assert re.fullmatch(r"sends out 3141.\d* lm of the 2800 lm .*, 112%: more than all; .*", told)
    (told,) = relative(1e6).notes
    assert told.endswith("of the 1e+06 lm of its lamps, 0.3%: hardly any; is a factor wrong?")


def test_eulumdat_is_scaled_by_lamps_and_states_its_flux():
    gamma = np.arange(0, 91, 2.5)
    values = 800 / np.pi * np.cos(np.radians(gamma))  # cd/klm: 80 % of the lamps
    (flat,) = (read(ldt(1, [0.0], values, gamma, lorl=80, sets=((2, 5000),)), "x.ldt"),)
    assert flat.flux == pytest.approx(4000, rel=2e-4) and flat.stated == 4000 and not flat.notes
    assert flat.opening == 1.1
    (told,) = read(ldt(1, [0.0], values, gamma, lorl=100, sets=((1, 5000),)), "x.ldt").notes
    assert "add up to 3999" in told and "5000 lm are stated (5000 lm of lamps, light output" in told
    twice = read(ldt(1, [0.0], values, gamma, lorl=160, factor=2, sets=((1, 5000),)), "x.ldt")
    assert twice.flux == pytest.approx(8000, rel=2e-4)


def test_other_lamps_of_eulumdat_are_noted():
    flat = np.full(13, 1000 / (4 * np.pi))
    sets = read(ldt(1, [0.0], flat, sets=((1, 2000), (1, 3000))), "x.ldt")
    assert sets.flux == pytest.approx(2000) and "has 2 sets of lamps: the first" in sets.notes[0]
    for sets in ((), ((1, 0),)):
        bare = read(ldt(1, [0.0], flat, sets=sets), "x.ldt")
        assert bare.flux == pytest.approx(1000) and "names no flux of its lamps" in bare.notes[0]
    absolute = read(ldt(1, [0.0], flat, lorl=70, sets=((-1, 2000),)), "x.ldt")
    assert absolute.flux == pytest.approx(2000) == absolute.stated and not absolute.notes
    (told,) = read(ldt(1, [0.0], flat, tilt=15), "x.ldt").notes
    assert told.startswith("was measured with a tilt of 15 degrees")


def test_eulumdat_takes_commas_for_points():
    text = ldt(1, [0.0], np.full(13, 0.5)).replace(".5", ",5")
    assert read(text, "x.ldt").candela.max() == 0.5


GOOD = ies([0, 90], [[9, 8], [7, 6]], (0, 90))
FIRST = "1 -1 1 2 2 1 2 0.1 0.2 0 1 1 20"
WRONG = [
    ("hello\n", "has no line TILT=, after which LM-63 files have their numbers"),
    ("", "has no line TILT="),
    (GOOD.replace("9 8", "9 -8"), "line 6: intensities = -8 (value 2 of plane 1) must be at least"),
    (GOOD.replace("9 8", "9 x"), "line 6: 'x' is no number that can be intensities"),
    (GOOD.replace("9 8", "9 nan"), "line 6: 'nan' is no number"),
    (GOOD.replace("9 8", "9 1e99"), "line 6: '1e99' is no number"),
    (GOOD.replace("7 6\n", "7\n"), "line 7: the file ends before intensities: 4 numbers must"),
    (GOOD.replace("9 8", "0 0").replace("7 6", "0 0"), "line 7: intensities are all 0"),
    (GOOD.replace("0 90\n0 90", "0 0\n0 90"), "line 4: the angles gamma must rise by 0.001"),
    (GOOD.replace("0 90\n0 90", "0 200\n0 90"), "line 4: the angles gamma must lie in [0, 180]"),
    (GOOD.replace("0 90\n0 90", "0 90\n0 80"), "line 5: the C-planes run from 0 to 80 degrees"),
    (GOOD.replace("0 90\n0 90", "0 90\n-90 90"), "line 5: the C-planes must lie in [0, 360]"),
    (GOOD.replace("2 2 1 2", "2 2 2 2"), "line 3: is of type B, whose axis is horizontal"),
    (GOOD.replace("2 2 1 2", "2 2 3 2"), "line 3: is of type A, whose axis is horizontal"),
    (GOOD.replace("2 2 1 2", "2 2 4 2"), "line 3: the type (1 is C, 2 is B, 3 is A) = 4 must be"),
    (GOOD.replace("2 2 1 2", "2 2 1 3"), "line 3: the unit of lengths (1 feet, 2 metres) = 3"),
    (GOOD.replace("2 2 1 2", "1 2 1 2"), "line 3: the number of angles gamma = 1 must be a whole"),
    (GOOD.replace("2 2 1 2", "2.5 2 1 2"), "line 3: the number of angles gamma = 2.5 must be a"),
    (GOOD.replace("2 2 1 2", "60000 60000 1 2"), "line 3: 60000 planes of 60000 angles are more"),
    (GOOD.replace("1 -1 1 2", "1 -1 0 2"), "line 3: the multiplier = 0 must be greater than 0"),
    (GOOD.replace("0 1 1 20", "0 -1 1 20"), "line 3: the ballast factor = -1 must be greater"),
    (GOOD.replace("1 -1 1 2", "1 -1 1e30 2").replace("9 8", "1e9 1"), "line 7: the largest of int"),
    (GOOD.replace("=NONE", "=INCLUDE"), "line 3: the number of tilt angles = -1 must be a whole"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "told"), WRONG, ids=[told[:50] for _, told in WRONG])
def test_wrong_lm_63_files_are_refused_with_line_value_and_bound(text, told):
    with pytest.raises(SceneError) as error:
        read(text)
    (problem,) = error.value.problems
    assert problem.startswith(told) and error.value.source == "x.ies"


LDT = ldt(4, np.arange(0, 360, 90.0), np.full((2, 13), 5.0))


def with_line(number, value):
    lines = LDT.split("\n")
    lines[number - 1] = value
    return "\n".join(lines)


WRONG_LDT = [
    ("IESNA91\n", "has 2 lines, an EULUMDAT file more than 26"),
    (with_line(3, "5"), "line 3: the symmetry Isym = 5 must be a whole number in [0, 4]"),
    (with_line(3, ""), "line 3: the file ends before the symmetry Isym"),
    (with_line(4, "1000"), "line 4: the number of C-planes Mc = 1000 must be a whole"),
    (with_line(6, "-3"), "line 6: the number of angles Ng = -3"),
    (with_line(24, "0"), "line 24: the conversion factor of intensities = 0 must be greater"),
    (with_line(26, "15"), "line 26: 15 sets of lamps do not fit"),
    (with_line(29, "many"), "line 29: 'many' is no number that can be the flux of the lamps"),
    (with_line(44, "80"), "line 46: symmetry 4 (about both) needs C-planes at 0 and 90 degrees"),
    (with_line(44, "300"), "line 46: the C-planes must rise by 0.001 degrees at least: 300 is"),
    (with_line(70, "-5"), "line 70: intensities = -5 (value 11 of plane 1) must be at least 0"),
    ("\n".join(LDT.split("\n")[:70]), "line 70: the file ends before intensities: 26 numbers"),
]


@pytest.mark.parametrize(("text", "told"), WRONG_LDT, ids=[told[:50] for _, told in WRONG_LDT])
def test_wrong_eulumdat_files_are_refused_with_line_value_and_bound(text, told):
    with pytest.raises(SceneError) as error:
        read(text, "x.ldt")
    (problem,) = error.value.problems
    assert problem.startswith(told)


def test_texts_of_no_photometric_file_are_not_taken_apart():
    with pytest.raises(SceneError, match="characters, at most"):
        read("TILT=NONE\n" + "1 " * (1 << 23))
