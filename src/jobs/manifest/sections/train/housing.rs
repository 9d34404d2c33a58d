//! The table `[train.housing]`, and the bearings on its nodes.

use crate::manifest::housing_file;
use crate::manifest::reader::Section;
use crate::manifest::schema::{nearest, quoted};
use crate::manifest::sections::Context;
use crate::shaft::{HousingJoint, JoinedHousing};

/// The housing with its joints; `Some(None)` without one.
pub(super) fn read(
    section: &Section,
    context: &mut Context,
    shafts: &[Section],
) -> Option<Option<JoinedHousing>> {
    let housing = section.optional("housing", |table| {
        let (file, span) = (table.text("file")?, table.span_of("file"));
        housing_file::load(section.issues, context, file, span)
    })?;
    let nodes = housing.iter().flat_map(|joined| &joined.nodes);
    let nodes: Vec<&str> = nodes.map(|node| node.name.as_str()).collect();
    let mut joints = Vec::new();
    for (shaft, table) in shafts.iter().enumerate() {
        for (bearing, bearing_table) in table.tables("bearings")?.iter().enumerate() {
            if !bearing_table.has("housing") {
                continue;
            }
            let name = bearing_table.text("housing")?;
            let Some(node) = nodes.iter().position(|node| *node == name) else {
                report_unknown_node(bearing_table, name, &nodes);
                return None;
            };
            joints.push(HousingJoint {
                bearing: [shaft, bearing],
                node,
            });
        }
    }
    Some(housing.map(|housing| JoinedHousing { housing, joints }))
}

/// Records a bearing on an unknown node.
fn report_unknown_node(bearing: &Section, name: &str, nodes: &[&str]) {
    let (message, remedy) = match nodes {
        [] => (
            format!("the bearing stands on `{name}`, but the train has no housing"),
            "add [train.housing] with the file of the housing, or remove `housing`".to_owned(),
        ),
        nodes => (
            format!("the housing has no node `{name}`"),
            nearest(name, nodes).map_or_else(
                || "give the name of a node of the housing file".to_owned(),
                |near| format!("did you mean \"{near}\"?"),
            ),
        ),
    };
    let mut fault = bearing.inconsistent("housing", message);
    if !nodes.is_empty() {
        fault = fault.accepted(quoted(nodes));
    }
    let fault = fault.label("no such node").remedy(remedy);
    fault.report(bearing.issues);
}
