//! Golden cases: short runs, followed orbits, traces and printed results that together cover every tier, kernel, mesh
//! law and analysis, compared with recorded results of this program. They detect that a change of the code has changed
//! a result, not which of the two is right; see README.md in this folder.

#![allow(clippy::unwrap_used)]

mod compare;
#[path = "../common/program.rs"]
mod program;

/// Cases: a name, a command, and the changed keys of its manifest.
macro_rules! golden {
    ($($name:ident: $command:literal [$($set:literal),* $(,)?];)*) => {
        $(#[test]
        fn $name() {
            compare::check(stringify!($name), $command, &[$($set),*]);
        })*

        #[test]
        fn recorded_are_these_cases() {
            let mut names = vec![$(concat!(stringify!($name), ".tsv")),*];
            names.sort_unstable();
            if compare::writes() {
                return;
            }
            let entries = std::fs::read_dir(compare::recorded_in()).unwrap();
            let mut files: Vec<_> = entries.map(|entry| entry.unwrap().file_name()).collect();
            files.sort();
            assert_eq!(files, names);
        }
    };
}

golden! {
    quickstart: "run manifests/quickstart.toml" [
        "grid.load=0.1", "grid.speed=700", "run.transient=10", "run.cycles=30",
        r#"analyses.nvh={harmonics=3,bearings=true,torques=true,accelerations=true,orders={mesh=2,shafts=2},spectrum={highest_order=2,resolution=8,signals=["deflection","force","bearings","torques","accelerations"]}}"#,
        "analyses.poincare.samples=3",
    ];
    rattle: "run manifests/quickstart.toml" [
        "grid.load=0.1", "grid.speed=1250", "run.transient=2", "run.cycles=12", "run.settle=false",
        "analyses.lyapunov={exponents=4,align=2,course=2}",
        "analyses.nvh={harmonics=3,bearings=true,torques=true,accelerations=true,orders={mesh=2,shafts=2},spectrum={highest_order=1,resolution=8}}",
        "analyses.poincare={samples=8,phase=0.3}",
    ];
    torsional: "run manifests/tiers/torsional.toml" [
        r#"shafts.pinion.drag="1e-3 N*m*s/rad""#, r#"shafts.wheel.drag_torque="0.5 N*m""#,
        "analyses.lyapunov={exponents=2,course=3,align=20}", "run.transient=20", "run.cycles=60",
        "analyses.poincare.samples=3",
    ];
    translational: "run manifests/tiers/translational.toml" [
        "grid.load=0.3", r#"shafts.bearings.damping_x="300 N*s/m""#, r#"shafts.bearings.damping_y="200 N*s/m""#,
        r#"shafts.bearings.damping_xy="40 N*s/m""#, r#"shafts.bearings.damping_yx="-30 N*s/m""#,
        r#"shafts.bearings.cross_xy="1e6 N/m""#, r#"shafts.bearings.cross_yx=["-1e6 N/m","-2e6 N/m"]"#,
        "analyses.nvh.bearings=true", "run.transient=2", "run.cycles=10", "run.settle=false",
        "analyses.lyapunov={exponents=3,align=5}", "mesh.release=force", "analyses.poincare.samples=3",
    ];
    tilting: "run manifests/tiers/tilting.toml" [
        "grid.load=-0.3", "grid.speed=1400", "model.gyroscopic=true", r#"gear.face_offset=["3 mm","-2 mm"]"#,
        r#"gear.web_thickness="12 mm""#, r#"gear.rim_diameter="60 mm""#, r#"shafts.pinion.inner_diameter="8 mm""#,
        r#"mesh.normal_backlash="22 um""#, "mesh.half_gap=", "run.transient=2", "run.cycles=10", "run.settle=false",
        "analyses.poincare.section=entry", "analyses.lyapunov={align=2}",
    ];
    pedestal: "run manifests/tiers/pedestal.toml" [
        "grid.load=0.3", "grid.speed=1200", "model.retained=14", "model.mta=true",
        "model.damping_overrides=[{mode=4,ratio=0.03}]", "run.transient=2", "run.cycles=10", "run.settle=false",
        "analyses.nvh.bearings=true", "analyses.poincare.section=force_maximum", "analyses.poincare.samples=8",
        "analyses.lyapunov={align=2}",
    ];
    flexible: "run manifests/tiers/flexible.toml" [
        "grid.load=0.3", "grid.speed=1200", "model.retained=16", "model.mta=true", "model.gyroscopic=true",
        r#"gear.hub_diameter=["40 mm","50 mm"]"#, r#"gear.hub_length="20 mm""#,
        r#"shafts.bearings.damping_x="500 N*s/m""#, r#"shafts.wheel.inner_diameter="10 mm""#, "run.transient=10",
        "run.cycles=20", "analyses.nvh={harmonics=3,bearings=true,torques=true}",
        "analyses.lyapunov={exponents=2,align=5}",
        r#"analyses.poincare={section="surface",samples=6,surface={displacement=[0,1,0,0,0,0,0,0,0,0,0,0,0,0,0,0],velocity=[0,0,1e-4,0,0,0,0,0,0,0,0,0,0,0,0,0],direction="rising"}}"#,
    ];
    matrices: "run tests/golden/matrices.toml" [];
    matrices_same_line: "run tests/golden/matrices.toml" [
        "mesh.coast_flank=same_line", "mesh.coast_symmetry=", "excitation.coast_transmission_error=",
        "mesh.stiffness=piecewise", "mesh.stiffness_harmonics=", "mesh.values=[3e8,2e8,2.5e8]",
        "mesh.mean_stiffness=", "mesh.release=force",
        "analyses.poincare.section=coast_entry",
    ];
    geared_pair: "run tests/manifests/geared-pair.toml" [
        "run.transient=5", "run.cycles=30", "analyses={poincare={samples=3},nvh={harmonics=2}}",
    ];
    stepping: "run manifests/tiers/translational.toml" [
        "run.kernel=stepping", "run.steps=256", "grid.load=0.3", "grid.speed=1400",
        "run.transient=2", "run.cycles=10", "run.settle=false", "mesh.release=force", "analyses.poincare.samples=3",
        "analyses.lyapunov={align=2}",
    ];
    table: "run manifests/flex80-table.toml" [
        "model.retained=20", "grid.load=0.3", "grid.speed=1200", "run.transient=2", "run.cycles=10",
        "run.settle=false", "mesh.segments=12", "excitation.table_harmonics=3",
        r#"gear.tip_relief={amount="8 um",length="2 mm"}"#, "analyses.poincare.samples=3",
        "analyses.lyapunov={align=2}",
    ];
    misaligned: "run manifests/misalignment.toml" [
        "model.retained=20", "grid.load=0.5", "grid.speed=1200", r#"grid."mesh.misalignment"=5e-4"#,
        "mesh.segments=10", "mesh.face=coupled", "run.transient=2", "run.cycles=10", "run.settle=false",
        "analyses.poincare.samples=3", "analyses.lyapunov={align=2}",
    ];
    independent: "run manifests/misalignment.toml" [
        "model.retained=20", "grid.load=0.5", "grid.speed=1200", r#"grid."mesh.misalignment"=5e-4"#,
        "mesh.segments=10", "mesh.contact=linear", "gear.plane=strain", "run.transient=2", "run.cycles=10",
        "run.settle=false", "analyses.poincare.samples=3", "analyses.lyapunov={align=2}",
    ];
    leads: "run manifests/misalignment.toml" [
        "model.retained=20", "grid.load=1", "grid.speed=1200", r#"grid."mesh.misalignment"=0"#, "mesh.segments=10",
        r#"gear.lead_crowning="4 um""#, r#"gear.lead_slope=["1 um",0]"#,
        r#"gear.end_relief={amount="3 um",length="4 mm"}"#, "mesh.shaft_tilt=false", "run.transient=5",
        "run.cycles=20", "analyses.poincare.samples=3",
    ];
    relieved: "run tests/data/relieved-drive.toml" [
        "grid.load=0.6", r#"grid.speed="3000 rpm""#, "model.modes=12",
        r#"gear.root_relief={amount="3 um",length="1 mm",course="parabolic"}"#, r#"gear.profile_crowning="2 um""#,
        r#"gear.profile_slope=["1 um","-2 um"]"#, "mesh.friction_law=schlenk", r#"mesh.roughness="0.4 um""#,
        r#"mesh.oil_viscosity="40 mPa*s""#, "run.transient=5", "run.cycles=20",
        "excitation.pitch_deviation={pinion=[0,1e-6,2e-6,0,-1e-6,0,1e-6,0,0,0,0,-2e-6,0,1e-6,0,0,0,1e-6,0,0,0,0,-1e-6]}",
        "analyses.poincare.samples=3",
    ];
    flank_points: "run tests/data/relieved-drive.toml" [
        "grid.load=0.6", r#"grid.speed="3000 rpm""#, "model.modes=12", "mesh.stiffness=table", "mesh.segments=12",
        "run.transient=5", "run.cycles=20", "mesh.friction=0.05", "gear.tip_relief=",
        r#"gear.profile_points=[{gear="pinion",diameter=["57 mm","59 mm","61 mm"],missing=[0,"2 um","6 um"],between="monotone"}]"#,
        r#"gear.lead_points=[{gear="wheel",place=["-8 mm",0,"8 mm"],missing=["4 um",0,"2 um"]}]"#,
        "mesh.face=independent", r#"gear.young_modulus=["206 GPa","110 GPa"]"#, r#"gear.bore="30 mm""#,
        "analyses.poincare.samples=3",
    ];
    helical: "run manifests/flex80-table.toml" [
        "model.retained=20", "grid.load=0.3", "grid.speed=1200", "run.transient=2", "run.cycles=6",
        "run.settle=false", "mesh.segments=12", r#"gear.helix_angle="15 deg""#, "mesh.misalignment=2e-4",
        "analyses.poincare.samples=3", "analyses.lyapunov={align=2}",
    ];
    pairs: "run manifests/pairs.toml" [
        "model.modes=12", "grid.load={values=[0,0.3]}", "grid.speed=1200", "run.transient=2", "run.cycles=5",
        "run.settle=false", "analyses.lyapunov={align=1}",
    ];
    slices: "run manifests/pairs.toml" [
        "model.modes=12", "grid.load=0.3", "grid.speed=1200", "run.kernel=stepping", "run.steps=256",
        "mesh.slices=2", "mesh.misalignment=3e-4", "run.transient=2", "run.cycles=8", "run.settle=false",
        "analyses.lyapunov={align=2}",
    ];
    clutch: "run manifests/trains/clutch.toml" [
        "grid.load=0.1", r#"grid.speed="1500 rpm""#, "run.transient=2", "run.cycles=8", "run.settle=false",
        "analyses.nvh={torques=true,accelerations=true}", "analyses.poincare.samples=3",
    ];
    clutch_hysteresis: "run manifests/trains/clutch-hysteresis.toml" [
        "grid.load=0.1", r#"grid.speed="1500 rpm""#, "run.transient=2", "run.cycles=8", "run.settle=false",
        "analyses.nvh={torques=true}", "analyses.poincare.samples=3",
    ];
    idle_rattle: "run manifests/trains/idle-rattle.toml" [
        r#"grid.speed="800 rpm""#, r#"grid."excitation.torque_ripple.0.amplitude"=30"#, "run.transient=3",
        "run.cycles=12", "run.settle=false", "analyses.poincare.samples=3", "analyses.lyapunov={align=2}",
    ];
    two_stage: "run manifests/trains/two-stage.toml" [
        "grid.load=0.2", r#"grid.speed="4000 rpm""#, "run.transient=10", "run.cycles=20",
        "analyses.nvh={bearings=true,torques=true}", "analyses.poincare.samples=3",
    ];
    sweep: "run manifests/speed-sweep.toml" [
        r#"model={kind="torsional"}"#, "grid.load=0.3", "grid.speed={from=1100,to=1500,count=3}",
        "run.instructions=portable", "analyses.poincare.refine=2", "analyses.poincare.samples=3",
        "run.transient=40", "run.cycles=60", "continuation=",
    ];
    refined: "run manifests/tiers/torsional.toml" [
        r#"grid={load={from=0.2,to=1,count=3},speed={from=900,to=1500,count=3},refine={levels=2,by=["deflection_rms"],tolerance=0.3}}"#,
        "analyses={lyapunov={align=2},nvh={harmonics=1}}", "run.transient=2", "run.cycles=5", "run.settle=false",
    ];
    points: "run manifests/points.toml" [
        "run.transient=1", "run.cycles=5", "run.settle=false", "analyses.poincare.samples=2",
        "analyses.lyapunov={align=2}",
    ];
    multistability: "run manifests/basins.toml" [
        "grid.speed=250", "analyses.multistability.initial_conditions=4", "analyses.multistability.slice.count=4",
        "analyses.multistability.transient=60", "analyses.multistability.cycles=320", "run.transient=20",
        "run.cycles=100",
    ];
    orbits: "run manifests/orbits/sparse.toml" [
        r#"model={kind="torsional"}"#, "grid.load=0.5", "run.instructions=portable", "run.transient=50",
        "run.cycles=320",
        "analyses={lyapunov={exponents=2,align=10},orbits={periods=[1,2],guesses=6,cycles=60,returns=4}}",
    ];
    horizon: "run manifests/horizon.toml" [
        r#"model={kind="torsional"}"#, "grid.load=0.3", "grid.speed=950", "run.instructions=portable",
        "run.transient=5", "run.cycles=320",
        r#"analyses={lyapunov={exponents=2,align=5,norm="raw",course=4,effort="survey"},horizon={twins=4,cycles=40,averages=40},nvh={harmonics=2,spectrum={highest_order=1,resolution=8}}}"#,
    ];
    covariant: "run manifests/tiers/torsional.toml" [
        "grid.load=1", "grid.speed=700",
        r#"excitation.torque_ripple=[{shaft="pinion",order=1.37,amplitude="5 N*m"}]"#, "run.transient=30",
        "run.cycles=330",
        "analyses={lyapunov={exponents=2},covariant={vectors=2,cycles=320,align=20},nvh={harmonics=1,spectrum={highest_order=1,resolution=8}}}",
    ];
    branches: "follow manifests/bifurcations.toml" [
        r#"model={kind="torsional"}"#, "grid.load={from=0.5,to=1,count=2}", "grid.speed={from=900,to=1300,count=2}",
        r#"continuation={over="speed",second="load",starts=2,longest_period=2,transient=20,cycles=20,branches=4}"#,
    ];
    traced: "trace manifests/quickstart.toml --point load=0.1,speed=1200 --cycles 1 --skip 5 --modal --outputs --samples-per-cycle 24" [];
    traced_pairs: "trace manifests/pairs.toml --point load=0.05,speed=1000 --cycles 1 --skip 3 --samples-per-cycle 24" [
        "model.modes=12",
    ];
    sensitivity: "sensitivity manifests/tiers/torsional.toml --point load=0.3,speed=1400" [
        "analyses.lyapunov={}",
    ];
    ensemble: "sensitivity manifests/cycle-expansion.toml --point load=0.3,speed=950 --members 4 --cycles 60 --by mesh.half_gap,load" [
        "run.instructions=portable", "run.transient=20", "run.cycles=320",
        r#"analyses={lyapunov={align=5,effort="survey"},nvh={harmonics=1}}"#,
    ];
    structure: "check manifests/trains/two-stage.toml" [];
    drawing: "check manifests/pairs.toml" [];
    covariant_chaos: "run manifests/tiers/torsional.toml" [
        "grid.load=0.3", "grid.speed=950", "run.instructions=portable", "run.transient=20", "run.cycles=320",
        r#"analyses={lyapunov={exponents=2,align=10,effort="survey"},covariant={vectors=2,cycles=320,align=20},poincare={section="force_maximum",samples=5}}"#,
    ];
    oscillator: "run tests/data/oscillator.toml" [
        "grid.load=0.3", "grid.speed={values=[600,1500]}", "run.transient=2", "run.cycles=8", "run.settle=false",
        r#"analyses.poincare={section="release",samples=4}"#, "analyses.lyapunov={align=2}",
    ];
    continuous: "run manifests/tiers/torsional.toml" [
        "mesh.stiffness=continuous", "mesh.segments=", "grid.load=0.3", "run.transient=10", "run.cycles=40",
        "run.initial=rest", r#"analyses.poincare={section="coast_release",samples=4}"#,
    ];
    steady: "run manifests/tiers/torsional.toml" [
        "grid.load=1", "grid.speed={values=[150,400]}", "run.settle=false", "run.transient=700", "run.cycles=40",
        "analyses.lyapunov={exponents=2,align=400}", "analyses.poincare.samples=2",
    ];
    steady_trace: "trace manifests/quickstart.toml --point load=1,speed=200 --cycles 1 --skip 1000 --samples-per-cycle 8" [
        "grid.load=1",
    ];
    enough: "run manifests/tiers/torsional.toml" [
        "grid.load=0.3", "grid.speed=950", "run.instructions=portable", "run.transient=20", "run.cycles=8000",
        r#"analyses={lyapunov={align=10,stop_at_stderr=0.01,effort="survey"},nvh={harmonics=2,stop_at_stderr=0.2,spectrum={highest_order=1,resolution=8},orders={mesh=2,shafts=1}}}"#,
    ];
    trajectories: "run manifests/tiers/torsional.toml" [
        "grid.load=0.3", "grid.speed=950", "run.instructions=portable", "run.transient=20", "run.cycles=",
        "analyses={lyapunov={exponents=2,align=10,course=4},nvh={harmonics=2,spectrum={highest_order=1,resolution=8},orders={mesh=2,shafts=1}}}",
    ];
    unstable_orbits: "run manifests/orbits/sparse.toml" [
        r#"model={kind="torsional"}"#, "grid.load=0.3", "grid.speed=950", "run.instructions=portable",
        "run.transient=20", "run.cycles=320",
        r#"analyses={lyapunov={align=10,effort="survey"},orbits={periods=[1,2,3],guesses=8,cycles=100,returns=4}}"#,
    ];
    attractors: "run manifests/tiers/torsional.toml" [
        "grid.load={values=[0.3,1]}", "grid.speed=1400", "run.transient=60", "run.cycles=120",
        "run.instructions=portable",
        r#"analyses={lyapunov={},multistability={initial_conditions=6,decades=6,transient=60,cycles=320,slice={mode=2,extent="40 um",count=4}}}"#,
    ];
    sensitivity_flexible: "sensitivity manifests/quickstart.toml --point load=0.3,speed=700" [
        "mesh.friction=0.05", r#"excitation.torque_ripple=[{shaft="pinion",order=20,amplitude="1 N*m",phase=0.3}]"#,
        "run.transient=50", "run.cycles=320",
    ];
    repeated: "run manifests/tiers/tilting.toml" [
        "grid.load=0.3", "grid.speed=1200", "model.gyroscopic=true", r#"shafts.bearings.y="1.25e8 N/m""#,
        r#"shafts.pinion.diameter="24 mm""#, r#"shafts.wheel.diameter="24 mm""#, "gear.teeth=[25,25]",
        r#"gear.body_length=["50 mm","50 mm"]"#, r#"shafts.bearings.damping_x="300 N*s/m""#, "run.transient=2",
        "run.cycles=8", "run.settle=false", "analyses.lyapunov={align=2}", "analyses.poincare.samples=3",
    ];
    stop: "run tests/golden/matrices.toml" [
        "grid.load=-0.4", "mesh.release=force", r#"analyses.poincare={section="release",samples=4}"#,
        "run.kernel=stepping", "run.steps=128",
    ];
    torques: "run manifests/tiers/pedestal.toml" [
        r#"grid={torque="-9 N*m",speed=900}"#, "mesh.stiffness=fourier",
        r#"mesh.stiffness_harmonics=[{harmonic=1,amplitude="5e7 N/m",phase=0.3},{harmonic=3,amplitude="1e7 N/m"}]"#,
        "mesh.contact_ratio=", "mesh.single_pair_drop=", "mesh.segments=", "mesh.coast_symmetry=0.1",
        "gear.profile_shift=[0.2,-0.1]", r#"gear.thinning="30 um""#, "mesh.half_gap=", "shafts.gear_position=0.6",
        "gear.rack={addendum=1.1,dedendum=1.4,tip_radius=0.3}", r#"gear.tip_diameter=["88 mm","127 mm"]"#,
        "run.transient=2", "run.cycles=8", "run.settle=false", "analyses.lyapunov={align=2}",
        "analyses.nvh={bearings=true,accelerations=true,spectrum={highest_order=1,resolution=8}}",
        r#"analyses.poincare={section="coast_entry",samples=3}"#,
    ];
    drawn_pairs: "run manifests/pairs.toml" [
        "model.modes=8", "grid.load=0.2", "grid.speed=900", "mesh.contact=linear", "mesh.release=force",
        "gear.teeth=[14,43]", "gear.profile_shift=[0.4,-0.3]", r#"gear.bore=["30 mm","100 mm"]"#, "mesh.slices=2",
        "mesh.misalignment=2e-4", "run.transient=2", "run.cycles=4", "run.settle=false",
        "analyses.lyapunov={align=1}",
    ];
    averages: "run manifests/tiers/translational.toml" [
        "grid.load=0.3", "grid.speed=950", "run.instructions=portable", "run.transient=20", "run.cycles=400",
        r#"analyses={lyapunov={align=10,effort="survey"},nvh={harmonics=2,bearings=true,accelerations=true,orders={mesh=2,shafts=1},spectrum={highest_order=1,resolution=8}}}"#,
    ];
    sensitivity_continuous: "sensitivity manifests/tiers/torsional.toml --point load=1,speed=400" [
        "mesh.stiffness=continuous", "mesh.segments=", "analyses.lyapunov={}",
    ];
}
