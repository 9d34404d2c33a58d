"""A drive cut at a shaft, its halves two FMUs, beside the whole, which SciPy integrates from the equations of its four wheels."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import solve_ivp

pytest.importorskip("fmpy")

from importer import instance, write  # noqa: E402

# Either half has two rigid wheels on one mesh; a row each. Between them is a shaft with a spring and a damper.
INERTIA = np.array([[2e-3, 5e-3], [4e-3, 2e-2]])  # kg m2
RADIUS = np.array([[0.04, 0.06], [0.06, 0.09]])  # m
TEETH, STIFFNESS, DAMPING, GAP, ERROR, RATED = (20, 30), 1e8, 400.0, 10e-6, 5e-6, 1000.0
SHAFT = np.array([2000.0, 1.0])  # N m/rad, N m s/rad
LINE, TURNS = RADIUS * [1, -1], np.array([1, TEETH[0] / TEETH[1]])
# An FMU's mesh follows the mean rotation of its half.
MEAN = INERTIA * TURNS / (INERTIA @ TURNS**2)[:, None]
MANIFEST = f"""
[job]
name = "half"
[model]
kind = "modal"
file = "half.modal.toml"
[mesh]
half_gap = {GAP}
stiffness = "constant"
mean_stiffness = {STIFFNESS}
contact_damping = "{DAMPING} N*s/m"
coast_flank = "same_line"
[excitation]
transmission_error = [{{ harmonic = 1, amplitude = {ERROR} }}]
[grid]
load = 1.0
speed = 100.0
"""


@pytest.fixture(scope="module")
def halves(tmp_path_factory) -> dict:
    files = {2: [], 3: []}
    for inertia, line in zip(INERTIA, LINE):
        folder = tmp_path_factory.mktemp("half")
        mesh, (a, b) = (line * inertia**-0.5).tolist(), inertia**-0.5
        modes = f"teeth = {TEETH[0]}\nteeth_wheel = {TEETH[1]}\nrated_force = {RATED}\nmesh = {mesh}\ntorque = {mesh}\n"
        modes += f"frequency = [0.0, 0.0]\ndamping = [0.0, 0.0]\ntorque_pinion = [{a}, 0.0]\ntorque_wheel = [0.0, {b}]\n"
        (folder / "half.modal.toml").write_text(modes)
        (folder / "half.toml").write_text(MANIFEST)
        for version, written in files.items():
            written.append(folder / f"{version}.fmu")
            write(folder / "half.toml", written[-1], "--fmi", str(version))
    return files


@dataclass
class Case:
    """It starts in balance at a speed; the torque on the first pinion steps to another one."""

    load: float
    speed: float
    torque: float
    time: float
    grid: float

    @property
    def balance(self):
        """Torques in the shaft between the halves and on the last wheel, at the start."""
        return RATED * self.load * RADIUS[:, 1]

    def coupled(self, files, scheme, length):
        """Torque in the shaft and both mesh forces on the grid, and the events of both meshes."""
        starts = [{"start.load": self.load, "start.speed": speed} for speed in self.speed * TURNS]
        with instance(files[0], values=starts[0]) as first, instance(files[1], values=starts[1]) as second:

            def twist():
                return first.get("wheel.angle", "wheel.speed") - second.get("pinion.angle", "pinion.speed")

            def step(torque, rate=None):
                first.set(wheel__torque=-torque)
                second.set(pinion__torque=torque)
                if rate is not None:
                    first.rate(wheel__torque=-rate)
                    second.rate(pinion__torque=rate)
                for own in (first, second):
                    own.fmu.doStep(number * length, length)
                return self.balance[0] + SHAFT @ (twist() - free)

            first.set(pinion__torque=self.torque)
            second.set(wheel__torque=-self.balance[1])
            free, torque, rate, rows = twist(), self.balance[0], 0.0, []
            for number in range(round(self.time / length)):
                if scheme == "corrected":
                    states = [(own, own.call("get#")()) for own in (first, second)]
                    rate = (step(torque, rate) - torque) / length
                    for own, state in states:
                        own.call("set#")(state)
                        own.call("free#")(state)
                inputs = {"held": [torque], "middle": [torque + 0.5 * length * rate]}.get(scheme, [torque, rate])
                before, torque = torque, step(*inputs)
                rate = (torque - before) / length
                if (number + 1) % round(self.grid / length) == 0:
                    rows.append([torque, *first.get("mesh.force"), *second.get("mesh.force")])
            return np.array(rows), [own.get("events")[0] for own in (first, second)]

    def whole(self):
        """The same of the whole. Its state is the rotation of the wheels beside that of the start, and its rate."""
        rotation = self.speed * np.outer(TURNS, TURNS)

        def deflection(time, state):
            """Of both meshes, and the rate."""
            angle, speed = state.reshape(2, 2, 2) + [rotation * time, rotation]
            phase, pace = (TEETH[0] * (MEAN * own).sum(1) for own in (angle, speed))
            return (LINE * angle).sum(1) - ERROR * np.cos(phase), (LINE * speed).sum(1) + ERROR * np.sin(phase) * pace

        def outputs(time, state):
            depth, rate = deflection(time, state)
            twist = state[[1, 5]] - state[[2, 6]] - [free, 0.0]
            force = np.where(flank, STIFFNESS * (depth - flank * GAP) + DAMPING * rate, 0.0)
            return np.array([self.balance[0] + SHAFT @ twist, *force])

        def motion(time, state):
            torque, *force = outputs(time, state)
            outside = np.array([[self.torque, -torque], [torque, -self.balance[1]]])
            return np.concatenate([state[4:], ((outside - LINE * np.array(force)[:, None]) / INERTIA).ravel()])

        def change(mesh):
            def left(time, state):
                depth = deflection(time, state)[0][mesh]
                return flank[mesh] * depth - GAP if flank[mesh] else GAP - abs(depth)

            left.terminal, left.direction = True, -1
            return left

        closed = GAP + RATED * self.load / STIFFNESS + ERROR
        angle = np.array([np.linalg.solve([line, mean], [closed, 0.0]) for line, mean in zip(LINE, MEAN)])
        free, flank, time, state = angle[0, 1] - angle[1, 0], np.array([1, 1]), 0.0, np.append(angle, np.zeros(4))
        grid, rows, events = self.grid * np.arange(1, round(self.time / self.grid) + 1), [], [0, 0]
        options = dict(method="DOP853", rtol=1e-12, atol=1e-13, max_step=1e-5, events=[change(0), change(1)])
        while time < grid[-1]:
            found = solve_ivp(motion, (time, grid[-1]), state, dense_output=True, **options)
            rows += [outputs(at, found.sol(at)) for at in grid[(grid > time) & (grid <= found.t[-1])]]
            time, state = found.t[-1], found.y[:, -1]
            for mesh in (mesh for mesh in (0, 1) if len(found.t_events[mesh])):
                events[mesh] += 1
                flank[mesh] = 0 if flank[mesh] else np.sign(deflection(time, state)[0][mesh])
        return np.array(rows), events


SCHEMES = (("held", 2, 1), ("middle", 3, 2), ("straight", 2, 2), ("corrected", 2, 2))
STEADY = Case(load=1.0, speed=100.0, torque=60.0, time=0.02, grid=4e-5)
RATTLE = Case(load=0.05, speed=300.0, torque=2.0, time=0.012, grid=1e-5)


# Errors of the torque with the largest step are those of docs/fmu.md. A mesh force at one time of a rattling motion may be
# on either side of an impact: there only the torque tells the order.
@pytest.mark.parametrize(
    ("case", "events", "told", "largest"),
    [(STEADY, 0, 3, (6.3e-3, 1.03e-4, 1.21e-4, 2.56e-5)), (RATTLE, 73, 1, (2.0e-2, 2.33e-3, 2.95e-3, 5.8e-4))],
    ids=["steady", "rattle"],
)
def test_halves_of_a_drive_come_to_the_whole(halves, case, events, told, largest):
    exact, expected = case.whole()
    assert sum(expected) == events
    for (scheme, version, order), known in zip(SCHEMES, largest):
        errors = []
        for length in case.grid / np.array([1, 2, 4]):
            found, counted = case.coupled(halves[version], scheme, length)
            assert counted == expected
            errors.append(np.sqrt(((found - exact) ** 2).mean(0)) / np.ptp(exact, axis=0))
        orders = -np.diff(np.log2(errors), axis=0)
        np.testing.assert_allclose(orders[:, :told], order, atol=0.1, err_msg=scheme)
        assert errors[0][0] == pytest.approx(known, rel=0.02), scheme
