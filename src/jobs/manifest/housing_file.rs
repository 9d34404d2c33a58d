//! Housing files: reduced matrices of a housing from any finite-element code. Their rows are named freedoms
//! (degrees of freedom). Diagnostics are those of the manifest, with places in the housing file.

use super::diagnostic::{Issues, Span};
use super::reader::Section;
use super::schema::{self, HOUSING_FILE};
use super::sections::Context;
use super::tree::{self, entries};
use super::{text, unknown};
use crate::shaft::{Housing, HousingNode, HousingPoint};
use std::sync::Arc;

/// Largest number of freedoms. A larger housing must be reduced before it is exported.
const MOST_FREEDOMS: usize = 400;

/// Names of the freedoms of a node, in their order in the matrices.
const FREEDOMS: [&str; 6] = HousingNode::FREEDOMS;

/// Reads the housing file that the manifest names at `span`, once per job.
pub(super) fn load(
    issues: &Issues,
    context: &mut Context,
    file: &str,
    span: Span,
) -> Option<Arc<Housing>> {
    let path = context.base_dir.join(file);
    if let Some(known) = context.housings.get(&path) {
        return known.clone();
    }
    let named = ("train.housing.file", span);
    let source = text::read_named(issues, &path, "the housing file", named);
    let housing = source.and_then(|source| parse(issues, source).map(Arc::new));
    context.housings.insert(path, housing.clone());
    housing
}

fn parse(issues: &Issues, source: usize) -> Option<Housing> {
    let before = issues.count();
    let tree = tree::parse(source, issues);
    if issues.count() > before {
        return None;
    }
    unknown::check(issues, &tree, HOUSING_FILE);
    read(&Section::root(&tree, issues, HOUSING_FILE))
}

/// Records an inconsistent value of a key.
fn refuse(section: &Section, key: &str, message: String, remedy: &str) {
    section
        .inconsistent(key, message)
        .label("in the housing file")
        .remedy(remedy)
        .report(section.issues);
}

fn read(root: &Section) -> Option<Housing> {
    if !root.has("node") {
        root.missing("node");
    }
    let tables = root.tables("node")?;
    let nodes: Vec<_> = tables.iter().map(|table| node(table)).collect();
    let internal = if root.has("internal") { root.texts("internal", None)? } else { Vec::new() };
    let mut housing = Housing {
        nodes: nodes.into_iter().collect::<Option<_>>()?,
        internal: internal.into_iter().map(str::to_owned).collect(),
        mass: Vec::new(),
        stiffness: Vec::new(),
        damping: Vec::new(),
        points: Vec::new(),
    };
    let names = housing.names();
    let nodes = housing.nodes.iter().map(|node| &node.name);
    if let Some(twice) = twice(nodes.collect()).or_else(|| twice(names.iter().collect())) {
        let message = format!("two nodes or freedoms have the name `{twice}`");
        refuse(root, "node", message, "give all of them different names");
        return None;
    }
    if names.is_empty() || names.len() > MOST_FREEDOMS {
        let message = format!(
            "the housing has {} freedoms, but 1 to {MOST_FREEDOMS} are accepted",
            names.len()
        );
        let remedy = "reduce it to fewer nodes and fewer internal modes, such as those below twice the highest frequency of interest";
        refuse(root, "node", message, remedy);
        return None;
    }
    let mass = matrix(root, "mass", names.len());
    let stiffness = matrix(root, "stiffness", names.len());
    let damping = if root.has("damping") {
        matrix(root, "damping", names.len())
    } else {
        Some(Vec::new())
    };
    let tables = root.tables("point")?;
    let of_nodes = names.len() - housing.internal.len();
    let points = tables.iter().map(|table| point(table, &names, of_nodes));
    let points: Vec<_> = points.collect();
    housing.points = points.into_iter().collect::<Option<_>>()?;
    (housing.mass, housing.stiffness, housing.damping) = (mass?, stiffness?, damping?);
    if let Some(name) = twice(housing.points.iter().map(|point| &point.name).collect()) {
        let message = format!("two points have the name `{name}`");
        refuse(root, "point", message, "give all of them different names");
        return None;
    }
    if let Err(error) = housing.check() {
        let remedy = "check the export and its number of digits; symmetrise the matrix, or condense freedoms without mass into the \
                      others";
        refuse(root, error.matrix(), error.to_string(), remedy);
        return None;
    }
    Some(housing)
}

/// A name that occurs twice.
fn twice(mut names: Vec<&String>) -> Option<String> {
    names.sort_unstable();
    let pair = names.windows(2).find(|pair| pair[0] == pair[1])?;
    Some(pair[0].clone())
}

fn node(table: &Section) -> Option<HousingNode> {
    let name = table.text("name");
    let position = table.quantities("position", Some(3));
    let given = if table.has("freedoms") {
        table.choices("freedoms")?
    } else {
        FREEDOMS.to_vec()
    };
    let in_order = (FREEDOMS.into_iter())
        .filter(|freedom| given.contains(freedom))
        .eq(given.iter().copied());
    if !in_order {
        let message = format!(
            "`freedoms` must be some of {} in this order",
            FREEDOMS.join(", ")
        );
        let remedy = "sort rows and columns of the matrices alike";
        refuse(table, "freedoms", message, remedy);
        return None;
    }
    Some(HousingNode {
        name: name?.to_owned(),
        position: position?.try_into().ok()?,
        freedoms: FREEDOMS.map(|freedom| given.contains(&freedom)),
    })
}

/// A square matrix with one row per freedom, row by row.
fn matrix(root: &Section, name: &str, size: usize) -> Option<Vec<f64>> {
    let rows = root.rows(name)?;
    let fault = if rows.len() != size {
        format!("`{name}` has {} rows", rows.len())
    } else if let Some(row) = rows.iter().position(|row| row.len() != size) {
        let count = entries(rows[row].len());
        format!("row {} of `{name}` has {count}", row + 1)
    } else {
        return Some(rows.concat());
    };
    let message = format!("{fault}, but nodes and internal freedoms have {size} freedoms");
    let remedy = "give every matrix one row and one column per freedom: those of the nodes, then the internal ones";
    refuse(root, name, message, remedy);
    None
}

/// A point of the housing. The first `of_nodes` of the names are those of the nodes' freedoms.
fn point(table: &Section, names: &[String], of_nodes: usize) -> Option<HousingPoint> {
    let name = table.text("name")?.to_owned();
    if table.has("row") {
        table.given_twice(&["freedom"], "row", "describe the point");
        let row = table.quantities("row", Some(names.len()))?;
        return Some(HousingPoint { name, row });
    }
    let freedom = table.text("freedom")?;
    let known: Vec<&str> = names.iter().map(String::as_str).collect();
    let displaces = |known_freedom: &&str| {
        [" x", " y", " z"]
            .iter()
            .any(|end| known_freedom.ends_with(end))
    };
    let Some(place) = (known[..of_nodes].iter())
        .position(|known_freedom| *known_freedom == freedom && displaces(known_freedom))
    else {
        let near = schema::nearest(freedom, &known);
        let near = near.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
        let message = format!("`{freedom}` is not the displacement of a node{near}");
        let remedy = "give a node and x, y or z, such as \"left x\", or give `row`";
        refuse(table, "freedom", message, remedy);
        return None;
    };
    let mut row = vec![0.0; names.len()];
    row[place] = 1.0;
    Some(HousingPoint { name, row })
}
