"""FMUs that `atlas fmu` writes, in FMPy: both versions, their states, inputs and refusals, and what they compute."""

import ctypes
import shutil
import subprocess
import threading
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from program import ATLAS, ROOT

fmpy = pytest.importorskip("fmpy")
from fmpy.validation import validate_fmu  # noqa: E402

from importer import Instance, instance, write  # noqa: E402

QUICKSTART = ROOT / "manifests/quickstart.toml"
PERIOD = 2 * np.pi / (20 * 2 * np.pi * 6000 / 60)
RATED, RATIO = 50.0, 1.5
VERSIONS = (2, 3)

# Two wheels of known inertia on an elastic mode; names that no grammar likes.
INERTIA, RADIUS = (2e-3, 5e-3), (0.0376, 0.0564)
MODES = """
teeth = 20
teeth_wheel = 30
rated_force = 1330.0
frequency = [0.0, 0.0, 9000.0]
damping = [0.0, 0.0, 0.02]
mesh = [{p}, {w}, 0.4]
torque = [{p}, {w}, 0.0]
torque_pinion = [{a}, 0.0, 0.0]
torque_wheel = [0.0, {b}, 0.0]
[[bearing]]
name = 'it is "odd" <1> & \\'
gain = [0.0, 0.0, 2.1e7]
[[bearing]]
name = "it's é"
gain = [0.0, 0.0, 1e7]
""".format(
    a=INERTIA[0] ** -0.5,
    b=INERTIA[1] ** -0.5,
    p=RADIUS[0] * INERTIA[0] ** -0.5,
    w=-RADIUS[1] * INERTIA[1] ** -0.5,
)
MODAL = """
[job]
name = "odd"
[model]
kind = "modal"
file = "some folder/é.toml"
[mesh]
half_gap = "10 um"
stiffness = "constant"
mean_stiffness = "4e8 N/m"
contact_damping = 0.05
coast_flank = "same_line"
[grid]
load = 0.2
speed = { values = [100.0, 200.0] }
"""


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> dict:
    folder = tmp_path_factory.mktemp("fmu")
    (folder / "some folder").mkdir()
    (folder / "some folder" / "é.toml").write_text(MODES)
    (folder / "odd.toml").write_text(MODAL)
    files = {}
    for version in VERSIONS:
        for name, manifest in (("drive", QUICKSTART), ("odd", folder / "odd.toml")):
            files[name, version] = folder / f"{name}-{version}.fmu"
            write(manifest, files[name, version], "--fmi", str(version))
    return files


@pytest.mark.parametrize("version", VERSIONS)
def test_fmpy_finds_nothing(files, version):
    for name in ("drive", "odd"):
        assert validate_fmu(str(files[name, version])) == []
    names = [own.name for own in fmpy.read_model_description(str(files["odd", version])).modelVariables]
    assert "bearing.'it is \"odd\" <1> & \\\\'" in names and "bearing.'it\\'s é'" in names


def test_both_versions_have_the_same_bits(files):
    names = ("mesh.deflection", "mesh.force", "mesh.contact", "bearing.'pinion 1 y'", "wheel.speed", "events")
    found = []
    for version in VERSIONS:
        with instance(files["drive", version]) as own:
            found.append(own.steps(2000, 2e-4, names=names))
    np.testing.assert_array_equal(*found)
    assert found[0][-1, -1] > 1000 and set(found[0][:, 2]) >= {0, 1}


def test_simulation_by_fmpy(files):
    for version in VERSIONS:
        result = fmpy.simulate_fmu(
            str(files["drive", version]), stop_time=0.02, step_size=1e-3, output_interval=1e-3, output=["pinion.angle"]
        )
        assert abs(result["pinion.angle"][-1] / (0.02 * 200 * np.pi) - 1) < 1e-3


def test_motion_is_that_of_the_trace(files, tmp_path):
    """At the speed and load of the point, before chaos has made anything of round-off."""
    out, cycles, samples = tmp_path / "trace", 6, 16
    trace = [ATLAS, "trace", QUICKSTART, "--point", "0", "--skip", "0", "--cycles", str(cycles), "--outputs"]
    trace += ["--samples-per-cycle", str(samples), "--out", out, "--tables", tmp_path]
    subprocess.run(trace, check=True, capture_output=True)
    traced = pd.read_parquet(out / "trace.parquet")
    with instance(files["drive", 2]) as own:
        assert own.get("pinion.torque", "wheel.torque", "load") == pytest.approx([5.0, -7.5, 0.0], rel=1e-9)
        names = ("mesh.deflection", "mesh.force", "bearing.'pinion 1 y'", "torque.pinion")
        columns = ("deflection", "force", "bearing_pinion_1_y", "torque_pinion")
        found = own.steps(cycles * samples - 1, PERIOD / samples, names=names)
        assert own.get("events")[0] > 4
    for values, column in zip(found.T, columns):
        exact = traced[column][1 : cycles * samples].to_numpy()
        assert np.abs(values - exact).max() < 1e-8 * np.abs(exact).max(), column


@pytest.mark.parametrize("version", VERSIONS)
def test_the_drive_turns_as_a_rigid_body(files, version):
    """Mean rotation under torques that are not in balance: a closed form, whatever the mesh does."""
    ratio = RADIUS[0] / RADIUS[1]
    inertia = INERTIA[0] + INERTIA[1] * ratio**2
    names = ("pinion.angle", "wheel.angle", "pinion.speed", "wheel.speed", "mesh.force")
    with instance(files["odd", version]) as own:
        assert own.get("start.speed")[0] == 100.0
        own.set(pinion__torque=12.0, wheel__torque=-3.0)
        found = own.steps(4000, 1e-4, names=names)
        moved = (INERTIA[0] * found[:, 2] + INERTIA[1] * ratio * found[:, 3]) / inertia
        acceleration = (12.0 - 3.0 * ratio) / inertia
        time = 1e-4 * np.arange(1, 4001)
        np.testing.assert_allclose(moved, 100 + acceleration * time, rtol=1e-11)
        turned = (INERTIA[0] * found[:, 0] + INERTIA[1] * ratio * found[:, 1]) / inertia
        np.testing.assert_allclose(turned, 100 * time + acceleration * time**2 / 2, rtol=1e-9, atol=1e-9)
        # The mesh takes the wheel along.
        force = (3.0 + INERTIA[1] * acceleration * ratio) / RADIUS[1]
        assert found[-2000:, 4].mean() == pytest.approx(force, rel=0.02)


@pytest.mark.parametrize("version", VERSIONS)
def test_states_come_back_bit_by_bit(files, version):
    length = 1e-4
    with instance(files["drive", version]) as own, instance(files["odd", version]) as other:
        own.steps(300, length)
        state = own.call("get#")()
        saved = own.call("serialize#")(state)
        after = own.steps(300, length, first=300)
        own.call("set#")(state)
        np.testing.assert_array_equal(own.steps(300, length, first=300), after)
        own.call("free#")(state)
        again = own.call("deSerialize#" if version == 2 else "deserialize#")(saved)
        own.call("set#")(again)
        assert own.get("time")[0] == pytest.approx(300 * length)
        np.testing.assert_array_equal(own.steps(300, length, first=300), after)
        # A handle that exists is overwritten.
        before = again.value
        get = own.fmu.dll.fmi2GetFMUstate if version == 2 else own.fmu.dll.fmi3GetFMUState
        assert get(own.fmu.component, ctypes.byref(again)) == 0 and again.value == before
        end = own.get("mesh.deflection")
        own.steps(10, length, first=600)
        own.call("set#")(again)
        np.testing.assert_array_equal(own.get("mesh.deflection"), end)
        # Another instance takes it too, and a drive of another kind does not.
        with instance(files["drive", version]) as twin:
            handle = twin.call("deSerialize#" if version == 2 else "deserialize#")(saved)
            twin.call("set#")(handle)
            np.testing.assert_array_equal(twin.steps(300, length, first=300), after)
        with pytest.raises(Exception):
            other.call("set#")(again)
        own.call("free#")(again)
        for bad in (saved[:-3], saved + b"\0", b"x" + saved[1:], b""):
            with pytest.raises(Exception):
                own.call("deSerialize#" if version == 2 else "deserialize#")(bad)


def ramp(file, length, rates):
    """A torque that grows from the rated one on, in steps of some length; deflection, angle and speed after 40 ms."""
    with instance(file, values={"start.load": 1.0}) as own:
        own.set(wheel__torque=-1.5 * RATED)
        for step in range(round(0.04 / length)):
            own.set(pinion__torque=RATED + 400 * step * length)
            if rates:
                own.rate(pinion__torque=400.0)
            own.fmu.doStep(step * length, length)
        return own.get("mesh.deflection", "pinion.angle", "pinion.speed")


def test_input_derivatives_make_ramps_exact(files):
    exact = ramp(files["drive", 2], 1e-3, True)
    for length in (4e-3, 1e-4):
        np.testing.assert_allclose(ramp(files["drive", 2], length, True), exact, rtol=1e-8)
    errors = [abs(ramp(files["drive", 2], length, False)[1] / exact[1] - 1) for length in (2e-3, 1e-3, 5e-4)]
    assert errors[0] / errors[1] == pytest.approx(2, rel=0.1) and errors[1] / errors[2] == pytest.approx(2, rel=0.1)


@pytest.mark.parametrize("version", VERSIONS)
def test_steps_may_be_long_or_short(files, version):
    ends = []
    for length in (1e-4, 1e-3, 5e-3):
        with instance(files["odd", version], values={"start.load": 1.0}) as own:
            ends.append(own.steps(round(0.01 / length), length, names=("mesh.force", "pinion.speed"))[-1])
    np.testing.assert_allclose(ends[1:], [ends[0]] * 2, rtol=1e-8)


@pytest.mark.parametrize("version", VERSIONS)
def test_parameters_make_another_drive(files, version):
    usual, wide = {}, {"mesh.half_gap": 30e-6, "start.speed": 700.0}
    found = []
    for values in (usual, wide):
        with instance(files["drive", version], values=values) as own:
            found.append([*own.get("mesh.deflection", "pinion.speed"), own.steps(100, 1e-4)[-1, 0]])
    assert found[0][0] != found[1][0] and found[1][1] == pytest.approx(700.0, rel=1e-9)
    # In initialization mode too, where outputs can be read already.
    with instance(files["drive", version], initialized=False) as own:
        before = own.get("mesh.deflection")[0]
        own.set(**wide)
        own.fmu.exitInitializationMode()
        assert [before, own.get("mesh.deflection")[0]] == [found[0][0], found[1][0]]
        with pytest.raises(Exception):
            own.set(mesh__half_gap=20e-6)
        own.fmu.terminate()
        own.fmu.reset()
        own.set(mesh__half_gap=-1.0)
        own.fmu.setupExperiment(startTime=0.0) if version == 2 else None
        own.fmu.enterInitializationMode()
        with pytest.raises(Exception):
            own.fmu.exitInitializationMode()


@pytest.mark.parametrize("version", VERSIONS)
def test_a_step_that_fails_leaves_the_state(files, version):
    with instance(files["drive", version]) as own:
        own.steps(20, 1e-4)
        before = own.get("time", "mesh.deflection", "pinion.speed", "pinion.torque")
        own.set(pinion__torque=-1e5)
        dll, component = own.fmu.dll, own.fmu.component
        if version == 2:
            status = dll.fmi2DoStep(component, ctypes.c_double(before[0]), ctypes.c_double(0.5), 1)
            time = ctypes.c_double()
            assert dll.fmi2GetRealStatus(component, 2, ctypes.byref(time)) == 0 and time.value == before[0]
        else:
            flags, time = [ctypes.c_bool(True) for _ in range(3)], ctypes.c_double()
            pointers = [ctypes.byref(value) for value in (*flags, time)]
            status = dll.fmi3DoStep(component, ctypes.c_double(before[0]), ctypes.c_double(0.5), True, *pointers)
            assert not any(flag.value for flag in flags) and time.value == before[0]
        assert status == 2
        own.set(pinion__torque=before[3])
        np.testing.assert_array_equal(own.get("time", "mesh.deflection", "pinion.speed", "pinion.torque"), before)
        after = own.steps(20, 1e-4, first=20)
    with instance(files["drive", version]) as own:
        np.testing.assert_array_equal(own.steps(40, 1e-4)[20:], after)


@pytest.mark.parametrize("version", VERSIONS)
def test_wrong_calls_leave_the_importer_alive(files, version):
    file = files["drive", version]
    with instance(file) as own:
        own.steps(10, 1e-3)
        nan = float("nan")
        for bad in ((1.0, 1e-3), (0.01, 0.0), (0.01, -1e-3), (0.01, nan), (nan, 1e-3), (0.01, float("inf"))):
            with pytest.raises(Exception):
                own.fmu.doStep(*bad)
        get = own.fmu.getReal if version == 2 else own.fmu.getFloat64
        set_ = own.fmu.setReal if version == 2 else own.fmu.setFloat64
        for call in (
            lambda: get([9999]),
            lambda: get([own.references["events"]]),
            lambda: set_([own.references["mesh.force"]], [1.0]),
            lambda: set_([own.references["pinion.torque"]], [nan]),
            own.fmu.enterInitializationMode,
            own.fmu.exitInitializationMode,
        ):
            with pytest.raises(Exception):
                call()
        # Null pointers to every function but those that make or free.
        symbols = subprocess.run(["nm", "-D", "--defined-only", own.fmu.dll._name], check=True, capture_output=True, text=True)
        names = [line.split()[-1] for line in symbols.stdout.splitlines()]
        names = [name for name in names if name.startswith(f"fmi{version}")]
        assert len(names) == {2: 34, 3: 75}[version]
        for name in names:
            if any(word in name for word in ("Free", "Instantiate", "Version", "Platform", "Terminate", "Reset")):
                continue
            function = ctypes.CDLL(own.fmu.dll._name)[name]
            for handle in (None, ctypes.c_void_p(own.fmu.component)):
                assert function(handle, *[ctypes.c_void_p(0)] * 10) in (0, 3), name
        own.steps(10, 1e-3, first=10)


@pytest.mark.parametrize("version", VERSIONS)
def test_an_edited_resource_is_refused(files, version, capfd):
    file = files["drive", version]
    for spoil in (
        lambda folder: (folder / "manifest.toml").write_text("[job]\n"),
        lambda folder: (folder / "manifest.toml").open("a").write("# more\n"),
        lambda folder: (folder / "manifest.toml").unlink(),
        lambda folder: (folder / "drive.json").write_text("{}"),
    ):
        folder = fmpy.extract(str(file))
        spoil(Path(folder) / "resources")
        with pytest.raises(Exception):
            Instance(file, folder=folder)
        shutil.rmtree(folder)
    # The library prints nothing; what FMPy does with messages is its own.
    assert "panicked" not in capfd.readouterr().err


@pytest.mark.parametrize("version", VERSIONS)
def test_sixteen_threads_have_the_same_bits(files, version):
    # FMPy changes the working folder while it loads a library, so instances are made one after the other.
    folder, found = fmpy.extract(str(files["drive", version])), []
    owners = [Instance(files["drive", version], folder=folder) for _ in range(16)]

    def one(own):
        found.append(own.steps(300, 1e-4)[-1, 0])

    threads = [threading.Thread(target=one, args=[own]) for own in owners]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for own in owners:
        own.fmu.freeInstance()
    shutil.rmtree(folder)
    assert len(found) == 16 and len(set(found)) == 1


def test_point_and_keys_are_chosen(files, tmp_path):
    """Another point of the grid, changed keys, and files that the manifest names."""
    out = tmp_path / "other.fmu"
    write(files["odd", 2].parent / "odd.toml", out, "--point", "1", "--set", "mesh.half_gap=25 um")
    with instance(out) as own:
        assert own.get("start.speed", "mesh.half_gap") == pytest.approx([200.0, 25e-6], rel=1e-12)
        own.steps(10, 1e-3)
