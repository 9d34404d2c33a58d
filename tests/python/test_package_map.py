"""The exact cycle map of the Python package: its derivatives, its events, and a researcher's use of it."""

from pathlib import Path

import lyapynov
import numpy as np
import pytest

import gearatlas

ROOT = Path(__file__).resolve().parents[2]
QUICKSTART = ROOT / "manifests/quickstart.toml"


@pytest.fixture(scope="module")
def rattling() -> gearatlas.CycleMap:
    return gearatlas.CycleMap(gearatlas.load(QUICKSTART).point(load=0.1, speed="6000 rpm"))


@pytest.fixture(scope="module")
def states(rattling) -> np.ndarray:
    """States along a trajectory that rattles."""
    state, out = rattling(rattling.start(), 300), []
    for _ in range(50):
        state = rattling(state, 7)
        out.append(state)
    return np.array(out)


def test_cycles_compose(rattling, states):
    three = rattling(states, 3)
    np.testing.assert_array_equal(rattling(rattling(states), 2, first_cycle=1), three)
    np.testing.assert_array_equal(np.array([rattling(state, 3) for state in states]), three)
    np.testing.assert_array_equal(rattling(states, 0), states)
    # A window of the map is not its argument.
    assert not np.shares_memory(three, states)


def test_threads_do_not_change_bits(rattling, states):
    alone = gearatlas.CycleMap(rattling.point, threads=1)
    assert alone.threads == 1
    many = np.tile(states, (20, 1))
    np.testing.assert_array_equal(alone(many, 5), rattling(many, 5))


def test_the_map_is_the_trace(rattling, tmp_path):
    point = rattling.point
    traced = gearatlas.trace(point, cycles=5, skip=0, samples_per_cycle=1, modal=True, tables=tmp_path)
    image = rattling.image(rattling.start(), 5, events=True)
    path = np.array([rattling(rattling.start(), cycles) for cycles in range(5)])
    displacement, velocity = rattling.to_modal(path)
    for mine, theirs in ((displacement, "displacement"), (velocity, "modal_velocity")):
        theirs = traced.samples[theirs]
        np.testing.assert_allclose(mine, theirs, rtol=0, atol=1e-11 * np.abs(theirs).max())
    deflection, rate = rattling.deflection(path)
    np.testing.assert_allclose(deflection, traced.samples["deflection"], rtol=0, atol=1e-11 * rattling.half_gap)
    for column in ("cycle", "phase", "rate", "contact"):
        np.testing.assert_array_equal(image.events[column], traced.events[column])
    assert image.events.rows > 5 and set(image.events["state"]) == {0}
    # And back from modes to a state.
    again = rattling.from_modal(displacement[3], velocity[3])
    np.testing.assert_allclose(again, path[3], rtol=0, atol=1e-13 * np.abs(path[3]).max())


def test_the_jacobian_is_the_derivative(rattling, states):
    image = rattling.image(states[:5], 2, jacobian=True)
    weights, weighted = rattling.weights, rattling.weighted_components
    step = 1e-6
    for row, state in enumerate(states[:5]):
        for j in weighted[:: max(1, len(weighted) // 6)]:
            moved = np.repeat(state[np.newaxis], 2, axis=0)
            moved[0, j] += step / weights[j]
            moved[1, j] -= step / weights[j]
            ends = rattling(moved, 2)
            found = weights * (ends[0] - ends[1]) / (2 * step)
            exact = weights * image.jacobian[row, :, j] / weights[j]
            np.testing.assert_allclose(found[weighted], exact[weighted], rtol=0, atol=1e-6 * np.abs(exact).max())


def test_tangents_are_columns_of_the_jacobian(rattling, states):
    vectors = np.random.default_rng(1).normal(size=(len(states), 3, rattling.dimension))
    image = rattling.image(states, 2, tangents=vectors)
    matrices = rattling.image(states, 2, jacobian=True).jacobian
    expected = np.einsum("sij,skj->ski", matrices, vectors)
    np.testing.assert_allclose(image.tangents, expected, rtol=0, atol=1e-9 * np.abs(expected).max())
    assert image.jacobian is None
    np.testing.assert_array_equal(image.states, rattling(states, 2))


def test_the_jacobian_has_determinant_of_the_damping(rattling, states):
    """The volume of phase space shrinks as the damping says, events and contact aside: per cycle the
    same for all states of free flight, and never grows."""
    determinants = np.linalg.det(
        rattling.image(states, 1, jacobian=True).jacobian[:, rattling.weighted_components][:, :, rattling.weighted_components]
    )
    assert ((determinants > 0) & (determinants < 1)).all()


@pytest.mark.parametrize("key", ["load", "speed", "mesh.half_gap", "mesh.mean_stiffness", "shafts.bearings.x"])
def test_derivatives_by_keys_are_those_of_maps_at_other_values(rattling, states, key):
    by = rattling.image(states[:4], 2, by=[key]).by[key]
    value, weights, weighted = rattling.point[key], rattling.weights, rattling.weighted_components
    step = 1e-6 * value
    ends = [rattling.at({key: value + sign * step})(states[:4], 2) for sign in (1, -1)]
    found = (ends[0] - ends[1]) / (2 * step)
    for mine, theirs in zip(by, found):
        mine, theirs = (weights * mine)[weighted], (weights * theirs)[weighted]
        np.testing.assert_allclose(theirs, mine, rtol=0, atol=2e-5 * np.abs(mine).max())


def test_maps_at_other_values_know_them(rattling, states):
    """What was changed before stays when another key is changed, or differentiated by."""
    elsewhere = rattling.at({"mesh.half_gap": "14 um"}).at(load=0.12)
    assert (elsewhere.point["mesh.half_gap"], elsewhere.point.load) == (pytest.approx(14e-6), 0.12)
    assert elsewhere.half_gap == pytest.approx(14e-6)
    by = elsewhere.image(states[:2], by=["mesh.half_gap", "load"]).by
    for key, derivative in by.items():
        value = elsewhere.point[key]
        step = 1e-6 * value
        ends = [elsewhere.at({key: value + sign * step})(states[:2]) for sign in (1, -1)]
        found = (ends[0] - ends[1]) / (2 * step)
        scale = np.abs(elsewhere.weights * derivative).max()
        np.testing.assert_allclose(elsewhere.weights * found, elsewhere.weights * derivative, rtol=0, atol=2e-5 * scale)


def test_what_cannot_be_integrated_says_so(rattling, states):
    bad = states[:3].copy()
    bad[1] = 1e9
    image = rattling.image(bad, 1)
    assert list(image.stops) == [1] and "half gaps, but more than" in image.stops[1]
    assert np.isnan(image.states[1]).all() and np.isfinite(image.states[[0, 2]]).all()
    with pytest.raises(ValueError, match=rf"shape \(n, {rattling.dimension}\)"):
        rattling(np.zeros((2, 3)))
    with pytest.raises(ValueError, match="tangents must have the shape"):
        rattling.image(states, tangents=np.zeros((1, 1, 1)))
    with pytest.raises(gearatlas.AtlasError, match="is not a parameter"):
        rattling.image(states, by=["mesh.nothing"])


def test_other_kernels_have_maps(states):
    manifest = gearatlas.load(QUICKSTART, set={"run.kernel": "stepping", "run.steps": 4000})
    coarse = gearatlas.CycleMap(manifest.point(load=0.1, speed="6000 rpm"))
    exact = gearatlas.CycleMap(gearatlas.load(QUICKSTART).point(load=0.1, speed="6000 rpm"))
    assert (coarse.kernel, exact.kernel) == ("stepping", "closed_modes")
    apart = exact.weights * (coarse(states[:3]) - exact(states[:3]))
    assert 0 < np.abs(apart).max() < 1e-2


def test_newton_of_a_researcher_finds_the_orbit(rattling):
    """A fixed point by Newton's method in NumPy, where the run finds the motion periodic."""
    run = gearatlas.run(QUICKSTART, progress=False)
    periodic = [i for i, period in enumerate(run.points["period"]) if period == 1]
    assert periodic, "no point of the grid has period 1"
    mapped = gearatlas.CycleMap(gearatlas.load(QUICKSTART).point(int(periodic[0])))
    weighted, state = mapped.weighted_components, mapped(mapped.start(), 2000)
    for _ in range(8):
        image = mapped.image(state, jacobian=True)
        residual = (image.states[0] - state)[weighted]
        matrix = image.jacobian[0][np.ix_(weighted, weighted)]
        state[weighted] -= np.linalg.solve(matrix - np.eye(len(weighted)), residual)
    error = np.linalg.norm((mapped.weights * (mapped(state) - state))[weighted])
    assert error < 1e-10
    multipliers = np.linalg.eigvals(mapped.image(state, jacobian=True).jacobian[0][np.ix_(weighted, weighted)])
    assert np.abs(multipliers).max() < 1, "it attracts"


def test_a_foreign_package_finds_our_exponent():
    """The largest exponent of a chaotic point by the package lyapynov (QR method on a map and its
    Jacobian), against that of the run."""
    run = gearatlas.run(QUICKSTART, progress=False)
    chaotic = [i for i, kind in enumerate(run.points["class"]) if kind == "chaotic"]
    assert chaotic, "no point of the grid is chaotic"
    id = chaotic[0]
    mapped = gearatlas.CycleMap(gearatlas.load(QUICKSTART).point(id), threads=1)
    weighted, weights = mapped.weighted_components, mapped.weights[mapped.weighted_components]

    def whole(u: np.ndarray) -> np.ndarray:
        state = np.zeros(mapped.dimension)
        state[weighted] = u / weights
        return state

    def step(u: np.ndarray, _: float) -> np.ndarray:
        return weights * mapped(whole(u))[weighted]

    def jacobian(u: np.ndarray, _: float) -> np.ndarray:
        matrix = mapped.image(whole(u), jacobian=True).jacobian[0][np.ix_(weighted, weighted)]
        return weights[:, None] * matrix / weights

    system = lyapynov.DiscreteDS(weights * mapped.start()[weighted], 0, step, jacobian)
    cycles = 6000
    _, history = lyapynov.LCE(system, 1, 1000, cycles, True)
    # Growth a cycle, and the standard error of its mean from blocks.
    total = history[:, 0] * np.arange(1, cycles + 1)
    blocks = np.diff(total[99::100], prepend=0.0)[1:] / 100
    theirs, error = blocks.mean(), blocks.std(ddof=1) / np.sqrt(len(blocks))
    ours, own_error = run.points["lambda_max"][id], run.points["lambda_stderr"][id]
    assert abs(theirs - ours) < 4 * np.hypot(error, own_error), (theirs, error, ours, own_error)
    assert ours > 5 * own_error, "the point is chaotic"
