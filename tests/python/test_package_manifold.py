"""Manifolds of a saddle of a bistable oscillator: the map keeps them, and the stable one is the border of two basins."""

import subprocess
import sys

import numpy as np
import pytest

import gearatlas
from program import ROOT

MANIFEST = ROOT / "manifests/oscillators/one-sided-stop.toml"
GRID = {"speed": 2.8, "contact.stop.gap": {"from": 0.1, "to": 0.2, "count": 5}, "contact.stop.stiffness": 30.0}
CONTINUATION = {"over": "contact.stop.gap", "starts": 6, "longest_period": 2}


@pytest.fixture(scope="module")
def oscillator() -> gearatlas.Manifest:
    return gearatlas.load(MANIFEST, set={"grid": GRID, "continuation": CONTINUATION})


@pytest.fixture(scope="module")
def branches(oscillator, tmp_path_factory) -> gearatlas.Table:
    return gearatlas.follow(oscillator, tmp_path_factory.mktemp("out") / "case").branches


def placed(oscillator, row) -> tuple[gearatlas.CycleMap, np.ndarray]:
    mapped = gearatlas.CycleMap(oscillator.point(0)).at({"contact.stop.gap": row["contact.stop.gap"]})
    return mapped, mapped.from_modal(row["displacement"], row["modal_velocity"])


@pytest.fixture(scope="module")
def saddle(oscillator, branches) -> tuple[gearatlas.CycleMap, np.ndarray]:
    """A saddle of period 2 and the map where it is, in the middle of its branch."""
    rows = [row for row in branches if row["unstable"] == 1 and row["period"] == 2 and row["multiplier_re"] > 1.5]
    return placed(oscillator, rows[len(rows) // 2])


def size(mapped, states) -> np.ndarray:
    return np.linalg.norm(mapped.weights * states, axis=-1)


def distance(mapped, points, curve) -> np.ndarray:
    """Distance of points from a curve through states."""
    start, step, points = mapped.weights * curve[:-1], mapped.weights * np.diff(curve, axis=0), mapped.weights * points
    apart = points[:, np.newaxis] - start
    along = np.clip((apart * step).sum(axis=2) / (step**2).sum(axis=1), 0.0, 1.0)
    return np.linalg.norm(apart - along[:, :, np.newaxis] * step, axis=2).min(axis=1)


def test_states_of_branches_lie_on_their_orbits(oscillator, branches):
    for row in branches[:: max(1, len(branches) // 12)]:
        mapped, state = placed(oscillator, row)
        assert size(mapped, mapped(state, row["period"]) - state) < 1e-9 * size(mapped, state)


def test_the_map_keeps_the_manifolds(saddle):
    mapped, state = saddle
    for stable in (False, True):
        for branch in gearatlas.manifold(mapped, state, 2, stable=stable, length=20.0, step=0.01):
            assert np.array_equal(branch[0], state) and size(mapped, np.diff(branch, axis=0)).max() < 0.02
            inner = branch[: len(branch) // 3]
            assert distance(mapped, mapped(inner, 2), branch).max() < 0.5 * 0.01
    # The end of the stable manifold comes to the saddle, as near as what its error grows by lets it.
    branch = gearatlas.manifold(mapped, state, 2, stable=True, length=20.0, step=0.05)[0]
    nearest = min(size(mapped, mapped(branch[-1], cycles) - state) for cycles in range(2, 60, 2))
    assert nearest < 1e-3 * size(mapped, branch[-1] - state)


def test_the_stable_manifold_is_the_border_of_two_basins(saddle):
    mapped, state = saddle
    unstable = gearatlas.manifold(mapped, state, 2, length=1000.0)
    ends = [mapped(branch[-1], 400) for branch in unstable]
    assert size(mapped, ends[0] - ends[1]) > 0.1
    for branch in gearatlas.manifold(mapped, state, 2, stable=True, length=10.0, step=0.05):
        along = (mapped.weights * np.diff(branch, axis=0))[2::7]
        across = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.linalg.norm(along, axis=1)[:, np.newaxis]
        middle = 0.5 * (branch[:-1] + branch[1:])[2::7]
        sides = []
        for sign in (1.0, -1.0):
            ended = mapped(middle + sign * 0.02 * across / mapped.weights, 400)
            sides.append([int(size(mapped, own - ends[1]) < size(mapped, own - ends[0])) for own in ended])
        assert (np.array(sides[0]) != np.array(sides[1])).all()
        assert len(set(sides[0])) == 1


def test_only_saddles_with_one_direction_have_a_curve(oscillator, branches):
    stable = next(row for row in branches if row["stable"])
    mapped, state = placed(oscillator, stable)
    with pytest.raises(ValueError, match="0 multipliers outside the unit circle"):
        gearatlas.manifold(mapped, state, stable["period"])
    with pytest.raises(ValueError, match="2 multipliers inside"):
        gearatlas.manifold(mapped, state, stable["period"], stable=True)


def modal_map(folder, gaps: list[float], more: str = "") -> gearatlas.CycleMap:
    """The map of uncoupled oscillators under a shaker; each has a stop, unless there are no gaps."""
    count = max(1, len(gaps))
    text = f"frequency = {[1.0] * count}\ndamping = {[0.05] * count}\n" + more
    for own, gap in enumerate(gaps):
        participation = np.eye(count)[own].tolist()
        text += f'[[contact]]\nname = "stop-{own}"\nparticipation = {participation}\ngap = {gap!r}\nstiffness = 30.0\n'
    text += f'[[harmonic_load]]\nname = "shaker"\nforce = {[1.0] * count}\ncycles = [1, 1]\n'
    (folder / "own.modal.toml").write_text(text)
    model = {"kind": "modal", "file": str(folder / "own.modal.toml"), "length": 1.0}
    manifest = {"job": {"name": "own"}, "model": model, "grid": {"speed": 2.8}, "run": {"cycles": 100}}
    return gearatlas.CycleMap(gearatlas.load(manifest).point(0))


def test_the_surface_of_two_oscillators_is_the_product_of_their_curves(saddle, tmp_path):
    """Two oscillators without a coupling: the coordinates of each are on the curve of its own saddle."""
    single, state = saddle
    pair = modal_map(tmp_path, [float(single.point["contact.stop.gap"])] * 2)
    for stable in (False, True):
        # The curve has kinks at grazes, where chords are off by a part of their length.
        fine = 5e-4
        branches = gearatlas.manifold(single, state, 2, stable=stable, length=4.0, step=fine)
        curve = np.concatenate([branches[0][::-1], branches[1][1:]])
        both = np.repeat(state, 2)
        surface = gearatlas.manifold_surface(pair, both, 2, stable=stable, length=0.2, step=0.05)
        assert size(pair, surface[-1] - both).mean() >= 0.2
        assert size(pair, np.diff(surface, axis=1)).max() < 0.05
        for own in (0, 1):
            assert distance(single, surface[:, ::7, own::2].reshape(-1, 2), curve).max() < 0.5 * fine


def test_the_surface_of_a_growing_oscillation_is_its_plane(tmp_path):
    """The map of a linear oscillator with negative damping: the rings grow and turn with its multipliers."""
    linear = modal_map(tmp_path, [], "damping_matrix = [[-0.3]]\n")
    at_rest = np.zeros(2)
    image = linear.image(at_rest, 1, jacobian=True)
    slope = image.jacobian[0]
    orbit = np.linalg.solve(np.eye(2) - slope, image.states[0])
    surface = gearatlas.manifold_surface(linear, orbit, length=0.5, offset=1e-2, step=0.1, rings=4) - orbit
    assert np.allclose(surface[4:], surface[:-4] @ slope.T, atol=1e-13)
    areas = [0.5 * np.sum(ring[:, 0] * np.roll(ring[:, 1], -1) - ring[:, 1] * np.roll(ring[:, 0], -1)) for ring in surface]
    assert np.allclose(np.divide(areas[1:], areas[:-1]), np.linalg.det(slope) ** 0.25, rtol=1e-9)
    with pytest.raises(ValueError, match="0 multipliers inside the unit circle; its manifold is a surface only if there are two"):
        gearatlas.manifold_surface(linear, orbit, stable=True)


def test_the_example_finds_two_basins():
    command = [sys.executable, ROOT / "examples/manifolds.py"]
    told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    assert "a saddle of period 2, and 2 motions that attract" in told
