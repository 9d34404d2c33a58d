use super::*;
use crate::gear::GearError;

fn element() -> BeamElement {
    let material = Material {
        young_modulus: 206e9,
        shear_modulus: 79e9,
        density: 7850.0,
    };
    BeamElement::new(Section::solid(0.02).unwrap(), material, 0.9, 0.1).unwrap()
}

#[test]
fn annulus_has_the_inertia_of_its_solid_less_its_bore() {
    let annulus = Disc::annulus(0.2, 0.1, 0.05, 7800.0).unwrap();
    let outer = Disc::annulus(0.2, 0.0, 0.05, 7800.0).unwrap();
    let inner = Disc::annulus(0.1, 0.0, 0.05, 7800.0).unwrap();
    let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-13, "{a} {b}");
    close(annulus.mass, outer.mass - inner.mass);
    close(
        annulus.polar_inertia,
        outer.polar_inertia - inner.polar_inertia,
    );
    close(
        annulus.transverse_inertia,
        outer.transverse_inertia - inner.transverse_inertia,
    );
    // m R²/4 + m L²/12 of the solid cylinder.
    close(
        outer.transverse_inertia,
        outer.mass * (0.1f64.powi(2) / 4.0 + 0.05f64.powi(2) / 12.0),
    );
}

#[test]
fn elements_springs_and_discs_add_up() {
    let mut assembly = Assembly::new();
    let nodes = [(); 3].map(|()| assembly.add_node());
    assembly.add_beam(nodes[0], nodes[1], &element()).unwrap();
    assembly.add_beam(nodes[1], nodes[2], &element()).unwrap();
    assembly
        .add_spring(nodes[1], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
        .unwrap();
    let disc = Disc {
        mass: 7.0,
        transverse_inertia: 8.0,
        polar_inertia: 9.0,
    };
    assembly.add_disc(nodes[1], disc).unwrap();
    assembly.add_polar_inertia(nodes[1], 10.0).unwrap();
    let matrices = assembly.matrices().unwrap();
    let (k, m) = (element().stiffness(), element().mass());
    let inertia = [7.0, 7.0, 7.0, 8.0, 8.0, 19.0];
    for i in 0..NODE_FREEDOMS {
        let spring = (i + 1) as f64;
        let expected = k[6 + i][6 + i] + k[i][i] + spring;
        assert!((matrices.stiffness[(6 + i, 6 + i)] / expected - 1.0).abs() < 1e-15);
        let expected = m[6 + i][6 + i] + m[i][i] + inertia[i];
        assert!((matrices.mass[(6 + i, 6 + i)] / expected - 1.0).abs() < 1e-15);
        assert_eq!(matrices.stiffness[(i, 12 + i)], 0.0);
    }
}

#[test]
fn fixed_and_tied_freedoms_leave_the_matrices() {
    let mut assembly = Assembly::new();
    let (a, b, ground) = (
        assembly.add_node(),
        assembly.add_node(),
        assembly.add_node(),
    );
    for node in [a, b, ground] {
        for freedom in [
            Freedom::X,
            Freedom::Y,
            Freedom::Z,
            Freedom::RotationX,
            Freedom::RotationY,
        ] {
            assembly.fix(node, freedom).unwrap();
        }
    }
    assembly.fix(ground, Freedom::RotationZ).unwrap();
    assembly.add_beam(b, ground, &element()).unwrap();
    assembly.add_polar_inertia(a, 3.0).unwrap();
    assembly.add_polar_inertia(b, 5.0).unwrap();
    assembly.tie(b, a, Freedom::RotationZ, -2.0).unwrap();
    let matrices = assembly.matrices().unwrap();
    assert_eq!(matrices.mass.nrows(), 1);
    let (k, m) = (element().stiffness()[5][5], element().mass()[5][5]);
    assert!((matrices.stiffness[(0, 0)] / (4.0 * k) - 1.0).abs() < 1e-15);
    assert!((matrices.mass[(0, 0)] / (3.0 + 4.0 * (5.0 + m)) - 1.0).abs() < 1e-15);
    assert_eq!(
        matrices.functional(&[
            (a, Freedom::RotationZ, 1.0),
            (b, Freedom::RotationZ, 10.0),
            (ground, Freedom::RotationZ, 100.0),
        ]),
        vec![1.0 - 20.0]
    );
}

/// A disc and a spring at a distance from the node that carries them, in closed form.
#[test]
fn a_carried_node_moves_with_its_rigid_body() {
    let (offset, mass, stiffness) = (0.25, 7.0, 11.0);
    let mut assembly = Assembly::new();
    let body = assembly.add_node();
    let node = assembly.add_carried_node(body, offset).unwrap();
    let disc = Disc {
        mass,
        transverse_inertia: 2.0,
        polar_inertia: 3.0,
    };
    assembly.add_disc(node, disc).unwrap();
    assembly
        .add_spring(node, [stiffness, 0.0, 0.0, 0.0, 0.0, 0.0])
        .unwrap();
    let matrices = assembly.matrices().unwrap();
    let (m, k) = (&matrices.mass, &matrices.stiffness);
    assert_eq!(m.nrows(), NODE_FREEDOMS);
    let [x, y, tilt_x, tilt_y] = [0, 1, 3, 4];
    let steiner = 2.0 + mass * offset * offset;
    assert_eq!([m[(x, x)], m[(y, y)], m[(2, 2)]], [mass; 3]);
    assert_eq!([m[(tilt_x, tilt_x)], m[(tilt_y, tilt_y)]], [steiner; 2]);
    assert_eq!(m[(5, 5)], 3.0);
    // θ × offset e_z = offset (θy, −θx, 0)
    assert_eq!(
        [m[(x, tilt_y)], m[(y, tilt_x)]],
        [mass * offset, -mass * offset]
    );
    assert_eq!([m[(x, tilt_x)], m[(y, tilt_y)]], [0.0; 2]);
    assert_eq!(k[(x, tilt_y)], stiffness * offset);
    assert_eq!(k[(tilt_y, tilt_y)], stiffness * offset * offset);
    assert_eq!(k[(y, y)], 0.0);
    // A body that cannot tilt only translates.
    assembly.fix(body, Freedom::RotationY).unwrap();
    let held = assembly.matrices().unwrap();
    assert_eq!(
        held.functional(&[(node, Freedom::X, 2.0)]),
        [2.0, 0.0, 0.0, 0.0, 0.0]
    );
    assert_eq!(
        held.functional(&[(node, Freedom::Y, 1.0)]),
        [0.0, 1.0, 0.0, -offset, 0.0]
    );
}

#[test]
fn springs_between_nodes_feel_their_difference() {
    let mut assembly = Assembly::new();
    let (a, b) = (assembly.add_node(), assembly.add_node());
    assembly
        .add_spring_between(a, b, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
        .unwrap();
    let k = assembly.matrices().unwrap().stiffness;
    for i in 0..NODE_FREEDOMS {
        let spring = (i + 1) as f64;
        let found = [k[(i, i)], k[(i, 6 + i)], k[(6 + i, i)], k[(6 + i, 6 + i)]];
        assert_eq!(found, [spring, -spring, -spring, spring]);
    }
}

#[test]
fn misuse_is_refused() {
    let mut assembly = Assembly::new();
    let (a, b, c) = (
        assembly.add_node(),
        assembly.add_node(),
        assembly.add_node(),
    );
    assert_eq!(
        assembly.add_beam(a, 3, &element()),
        Err(ShaftError::NoSuchNode { node: 3, nodes: 3 })
    );
    assert!(matches!(
        assembly.add_spring(a, [-1.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        Err(ShaftError::Gear(GearError::Negative { .. }))
    ));
    let bound = |node, master| Some(ShaftError::TiedToBound { node, master });
    assert_eq!(assembly.tie(a, a, Freedom::X, 1.0).err(), bound(a, a));
    assembly.tie(a, b, Freedom::X, 1.0).unwrap();
    assert_eq!(assembly.tie(c, a, Freedom::X, 1.0).err(), bound(c, a));
    // The master may become fixed after the tie.
    assembly.fix(b, Freedom::X).unwrap();
    assert_eq!(assembly.matrices().err(), bound(a, b));
    let carried = assembly.add_carried_node(c, 0.1).unwrap();
    let chain = assembly.add_carried_node(carried, 0.1).unwrap();
    let mut free = assembly.clone();
    free.tie(a, c, Freedom::X, 1.0).unwrap();
    assert_eq!(free.matrices().err(), bound(chain, carried));
    assert!(matches!(
        assembly.add_carried_node(c, f64::INFINITY),
        Err(ShaftError::NotFinite { .. })
    ));
    assert!(matches!(
        assembly.add_shaft(
            &[0.0],
            Section::solid(0.02).unwrap(),
            Material {
                young_modulus: 1.0,
                shear_modulus: 1.0,
                density: 1.0,
            },
            0.9
        ),
        Err(ShaftError::NoElement { .. })
    ));
}
