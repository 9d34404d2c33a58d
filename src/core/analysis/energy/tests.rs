#![allow(clippy::unwrap_used)]
use super::*;
use crate::model::{DriveShaft, InitialState, OperatingPoint, TorqueRipple, fixtures};
use crate::propagate::{Counters, Kernel, Volterra};
use crate::structure::{Coupling, ModalStructure};

/// Largest energy stored \[J\], sum of all works \[J\] and residual \[1\] over a few cycles from rest.
fn audited(coupling: Option<Coupling>, friction: f64) -> [f64; 3] {
    let structure = ModalStructure {
        friction: vec![0.2, -0.3],
        friction_lever: vec![5.0, 3.0],
        pinion_torque: Some(vec![20.0, 9.0]),
        coupling,
        ..fixtures::structure(&[4288.0, 8171.0], 0.02, &[0.72, -0.48], &[0.33, 0.05])
    };
    let ripple = TorqueRipple {
        shaft: DriveShaft::Pinion,
        order: 2.0,
        amplitude: 1.5,
        phase: 0.3,
    };
    let drive = crate::model::Drive {
        friction,
        torque_ripple: vec![ripple],
        ..fixtures::two_level_mesh(10e-6)
    };
    let point = OperatingPoint {
        load: 0.3,
        speed: 1200.0,
    };
    let model = Model::new(&structure, &drive, point).unwrap();
    let kernel = Volterra::new(&model, f64::EPSILON, 1000);
    let mut trajectory = model.start(&InitialState::Static);
    let mut audit = EnergyAudit::new(&model);
    let mut counters = Counters::default();
    let mut workspace = kernel.workspace();
    (kernel.advance(
        4,
        &mut trajectory,
        &mut workspace,
        &mut audit,
        &mut counters,
    ))
    .unwrap();
    let coupled = audit.balance.model().basis.coupled();
    assert_eq!(coupled.is_some(), structure.coupling.is_some());
    let residual = audit.residual(&trajectory).unwrap();
    [audit.stored, audit.turnover, residual]
}

/// If modes are declared as coupled but have zero coupling, energies, works and the scale of the residual do
/// not change.
#[test]
fn energies_of_coupled_modes_are_those_of_modes() {
    let plain = audited(None, 0.0);
    assert!(plain[2] < 1e-11, "{plain:?}");
    // The order of magnitude is that of some hundred newtons over some ten micrometres.
    assert!(plain[0] > 1e-6 && plain[0] < 1.0, "{plain:?}");
    let nothing = Coupling {
        damping: vec![0.0; 4],
        gyroscopic: vec![0.0; 4],
        stiffness: vec![0.0; 4],
    };
    let coupled = audited(Some(nothing), 0.0);
    assert!(coupled[2] < 1e-11, "{coupled:?}");
    for (a, b) in plain.iter().zip(coupled).take(2) {
        assert!((a / b - 1.0).abs() < 1e-6, "{plain:?} {coupled:?}");
    }
}

/// The balance closes with every kind of coupling: the works of dampers, gyroscopic terms and skew springs
/// are counted.
#[test]
fn the_balance_of_coupled_modes_closes() {
    let coupling = Coupling {
        damping: vec![40.0, -15.0, -15.0, 60.0],
        gyroscopic: vec![0.0, 0.3, -0.3, 0.0],
        stiffness: vec![2e6, 1e6, -5e5, 3e6],
    };
    let coupled = audited(Some(coupling), 0.05);
    assert!(coupled[2] < 1e-11, "{coupled:?}");
}
