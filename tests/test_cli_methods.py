"""``--method`` on the command line: pictures without a solution, and what contradicts it."""

import numpy as np
import pytest
from test_cli import BOX, radiosity, refused


def pixels(tmp_path, *options, verb="render"):
    out = tmp_path / "picture.npy"
    args = ["-o", str(out)] if verb == "render" else ["--screenshot", str(out)]
    process = radiosity(verb, BOX, *args, "--size", "16x12", "--samples", "16", *options)
    assert process.returncode == 0, process.stderr
    return np.load(out), process.stderr


def test_methods_are_chosen(tmp_path):
    gathered, _ = pixels(tmp_path)
    traced, told = pixels(tmp_path, "--method", "raytrace")
    assert "solved" not in told
    local, _ = pixels(tmp_path, "--method", "local")
    assert traced.mean() < 0.9 * gathered.mean()
    assert local.mean() == pytest.approx(gathered.mean(), rel=0.15)
    bare, _ = pixels(tmp_path, "--method", "local", "--no-shadows")
    assert bare.shape == local.shape


def test_view_writes_the_picture_of_a_method(tmp_path):
    shot = tmp_path / "shot.png"
    process = radiosity("view", BOX, "--method", "local", "--size", "16x12", "--screenshot", shot)
    assert process.returncode == 0 and shot.exists() and "solved" not in process.stderr


@pytest.mark.parametrize("verb", ["render", "view"])
@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--method", "trace"], ["--method 'trace'", "gather, raytrace, local"]),
        (["--no-shadows"], ["leave out the shadows", '"gather" always models them']),
        (["--method", "raytrace", "--no-shadows"], ['"raytrace" always models']),
        (["--method", "local", "--mesh", "4"], ["--mesh belongs to --method gather"]),
        (["--method", "local", "--solver", "gmres"], ["--solver belongs to"]),
        (["--method", "raytrace", "--time", "3s"], ["--time belongs to"]),
        (["--method", "raytrace", "--order", "0"], ["--order belongs to"]),
        (["--method", "raytrace", "--force"], ["--force belongs to"]),
        (["--method", "raytrace", "--memory", "1GB"], ["--memory belongs to"]),
    ],
)
def test_what_contradicts_a_method_is_refused(verb, options, words, tmp_path):
    out = str(tmp_path / "a.png")
    args = ["-o", out] if verb == "render" else ["--screenshot", out]
    refused(radiosity(verb, BOX, *args, *options), *words)
