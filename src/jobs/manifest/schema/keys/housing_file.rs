//! The keys of a housing file.

use crate::manifest::schema::key::{ANY, Key, Kind, choice, key, quantity, table};
use crate::shaft::HousingNode;
use crate::units::Dimension::{Length, Ratio};

#[rustfmt::skip]
pub(super) const KEYS: &[Key] = &[
    key("mass", Kind::List("rows of the matrix"), ANY, "[[2.0, 0.1], [0.1, 1.0]]")
        .about("Mass matrix, symmetric and positive definite, in kg, kg m and kg m^2. All matrices have one row and one column \
                per freedom: first the freedoms of the nodes, node by node, then the internal freedoms."),
    key("mass.*", Kind::List("numbers"), ANY, "[2.0, 0.1]"),
    quantity("mass.*.*", Ratio, ANY, "2.0"),
    key("stiffness", Kind::List("rows of the matrix"), ANY, "[[3e8, -1e6], [-1e6, 4e8]]")
        .about("Stiffness matrix, symmetric and without negative eigenvalues, in N/m, N and N m. It includes the supports of the \
                housing."),
    key("stiffness.*", Kind::List("numbers"), ANY, "[3e8, -1e6]"),
    quantity("stiffness.*.*", Ratio, ANY, "3e8"),
    key("damping", Kind::List("rows of the matrix"), ANY, "[[300.0, 0.0], [0.0, 400.0]]").otherwise("none")
        .about("Viscous damping matrix, symmetric and without negative eigenvalues, in N s/m, N s and N m s. It acts in \
                addition to `model.damping`, which damps all elastic modes of the train."),
    key("damping.*", Kind::List("numbers"), ANY, "[300.0, 0.0]"),
    quantity("damping.*.*", Ratio, ANY, "300.0"),
    key("internal", Kind::List("names"), ANY, r#"["mode 1"]"#).or("[]")
        .about("Names of the internal freedoms, such as the fixed-interface modes of a Craig-Bampton reduction."),
    key("internal.*", Kind::Text, ANY, r#""mode 1""#),
    key("node", Kind::List("tables"), ANY, r#"[{ name = "left", position = [0, 0, 0], freedoms = ["x"] }]"#)
        .about("The nodes, one table `[[node]]` each. Bearings stand on nodes."),
    table("node.*"),
    key("node.*.name", Kind::Text, ANY, r#""left""#)
        .about("Name of the node. Bearings give it as `housing`."),
    key("node.*.position", Kind::List("3 lengths"), ANY, r#"["40 mm", 0, 0]"#).of_length(3)
        .about("Position in space, in the axes of `train.shaft.*.origin`. Its bearings must be at most 1 mm away."),
    quantity("node.*.position.*", Length, ANY, r#""40 mm""#),
    key("node.*.freedoms", Kind::List("freedoms"), ANY, r#"["x", "y", "z"]"#).or(r#"["x", "y", "z", "rx", "ry", "rz"]"#)
        .about("Freedoms of the node in the matrices, in this order: displacements along the axes of space in m, then \
                rotations about them in rad. The other ones are held."),
    choice("node.*.freedoms.*", &HousingNode::FREEDOMS, r#""z""#),
    key("point", Kind::List("tables"), ANY, r#"[{ name = "cover", freedom = "left x" }]"#).or("[]")
        .about("Response points, one table `[[point]]` each. Results have the acceleration of each."),
    table("point.*"),
    key("point.*.name", Kind::Text, ANY, r#""cover""#)
        .about("Name of the point. Results call it `housing` and this name."),
    key("point.*.freedom", Kind::Text, ANY, r#""left x""#).otherwise("none; required without `row`")
        .about("The displacement of a node that the point follows, as node and freedom."),
    key("point.*.row", Kind::List("numbers, one per freedom"), ANY, "[0.5, 0.5]").otherwise("none; required without `freedom`")
        .about("Displacement of the point in m per unit of each freedom, instead of `freedom`."),
    quantity("point.*.row.*", Ratio, ANY, "0.5"),
];
