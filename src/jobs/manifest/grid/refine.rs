//! `grid.refine`: are the cells of the grid halved where points on their edges differ, and how?

use super::grid_axis::GridAxis;
use super::values::MAX_POINTS;
use crate::manifest::diagnostic::{Diagnostic, DiagnosticKind, Issues, Span};
use crate::manifest::reader::Section;
use crate::manifest::schema::{self, Kind, MANIFEST};
use crate::manifest::spec::{Criterion, Refine};
use crate::numerics::nested_grid::NestedGrid;
use strum::VariantArray;

/// How the grid over `axes` is refined; their values become those of the finest grid. `None` if it is not refined, or
/// if there is a fault, which is reported. `whole` means that no axis has a fault.
pub(super) fn read(
    root: &Section,
    grid: &Section,
    axes: &mut [GridAxis],
    ties: &[Vec<usize>],
    whole: bool,
) -> Option<Refine> {
    let section = grid.child("refine")??;
    let levels = section.integer("levels");
    let by = criteria(root, &section);
    let [tolerance, longest] = ["tolerance", "longest_period"]
        .map(|key| section_for_criteria(&section, key, by.as_deref().unwrap_or_default()));
    let tolerance = tolerance.quantity("tolerance");
    let longest = longest.integer("longest_period");
    let impossible = |message: &str| section.whole_fault(DiagnosticKind::Inconsistent, message);
    if super::is_carried(root) {
        return impossible("`grid.refine` cannot carry a state: refined points start independently")
            .label("with `grid.order`")
            .remedy(
                "set order = \"independent\", or remove refine; analyses.poincare.refine locates changes along \
                 a carried state",
            )
            .fail(root.issues);
    }
    if !ties.is_empty() {
        return impossible("`grid.refine` divides a plane of two axes, but axes of this grid advance together")
            .label("with tied axes or samples")
            .remedy("remove refine, or give two axes separate ranges instead of grid.tied, grid.points or distributions")
            .fail(root.issues);
    }
    let levels = levels?;
    if !whole {
        return None;
    }
    let varied = plane(section.span, root.issues, axes)?;
    let nested = NestedGrid {
        coarse: varied.map(|axis| axes[axis].axis.values.len()),
        levels,
    };
    fits(&section, nested)?;
    for axis in varied {
        let values = &mut axes[axis].axis.values;
        *values = values.halved(levels)?;
    }
    Some(Refine {
        nested,
        by: by?,
        tolerance: tolerance?,
        longest_period: longest?,
    })
}

/// The criteria of comparison. Reports a criterion that no requested analysis computes.
fn criteria(root: &Section, section: &Section) -> Option<Vec<Criterion>> {
    let words = section.choices("by")?;
    let named = |criterion: &&Criterion| words.contains(&criterion.name());
    let by: Vec<Criterion> = Criterion::VARIANTS.iter().filter(named).copied().collect();
    if by.is_empty() {
        return section
            .inconsistent("by", "`grid.refine.by` is empty")
            .label("nothing to compare")
            .remedy("name a criterion, or remove by")
            .fail(root.issues);
    }
    let analyses = root.entry("analyses").map(|analyses| &analyses.node);
    let computed = |name: &str| analyses.is_some_and(|tables| tables.entry(name).is_some());
    let missing_analysis = (by.iter().copied())
        .find_map(|criterion| Some((criterion, criterion.analysis().filter(|a| !computed(a))?)));
    if let Some((criterion, analysis)) = missing_analysis {
        let name = criterion.name();
        let message = format!("`{name}` is not computed without analyses.{analysis}");
        return section
            .inconsistent("by", message)
            .label("not computed")
            .remedy(format!(
                "add {analysis} = {{}} to [analyses], or remove {name}"
            ))
            .fail(root.issues);
    }
    Some(by)
}

/// The section from which `key` is read. It has no entries if no criterion in `by` uses the key.
fn section_for_criteria<'t>(section: &Section<'t>, key: &str, by: &[Criterion]) -> Section<'t> {
    let (of_numbers, why, remedy) = match key {
        "tolerance" => (
            true,
            "because no column is compared",
            "name a column in by, or remove tolerance",
        ),
        _ => (
            false,
            "because neither class nor period is compared",
            "name class or period in by, or remove longest_period",
        ),
    };
    let effective = by.is_empty()
        || by
            .iter()
            .any(|criterion| criterion.is_number() == of_numbers);
    if !effective {
        section.without_effect(&[key], why, remedy);
    }
    section.if_effective(effective)
}

/// The two axes that vary. They must be even ranges that can be halved.
fn plane(span: Span, issues: &Issues, axes: &[GridAxis]) -> Option<[usize; 2]> {
    let several = |axis: &usize| axes[*axis].axis.values.len() > 1;
    let varied: Vec<usize> = (0..axes.len()).filter(several).collect();
    let fault = |span: Span, message: String| {
        Diagnostic::new(DiagnosticKind::Inconsistent, span, "grid.refine", message)
    };
    let Ok(varied) = <[usize; 2]>::try_from(varied.as_slice()) else {
        let names: Vec<&str> = varied.iter().map(|&axis| axes[axis].axis.name()).collect();
        let found = if names.is_empty() {
            "none has".to_owned()
        } else {
            format!("{} of them: {}", names.len(), names.join(", "))
        };
        let message = format!(
            "`grid.refine` divides a plane, so exactly two axes of the grid must have several values ({found})"
        );
        return fault(span, message)
            .label("not a plane")
            .remedy("give two axes several values and all others one value")
            .fail(issues);
    };
    let mut fits = true;
    for axis in varied.map(|axis| &axes[axis]) {
        let name = axis.axis.name();
        let whole = schema::find(MANIFEST, name).is_some_and(|key| key.kind == Kind::Integer);
        let (message, label, remedy) = if whole {
            (
                format!("`{name}` takes whole numbers, so its intervals cannot be halved"),
                "whole numbers",
                "refine over keys that take any number",
            )
        } else if axis.axis.values.halved(0).is_none() {
            (
                format!(
                    "`{name}` is a list of values, but `grid.refine` halves the intervals of a range"
                ),
                "not an even range",
                "give the axis as { from, to, count }; add spacing = \"log\" for equal ratios",
            )
        } else {
            continue;
        };
        issues.push(fault(axis.key_span, message).label(label).remedy(remedy));
        fits = false;
    }
    fits.then_some(varied)
}

/// Checks that the finest grid has no more points than accepted.
fn fits(section: &Section, nested: NestedGrid) -> Option<()> {
    let points = |levels: u32| {
        let [rows, columns] = nested
            .coarse
            .map(|places| ((places as u128 - 1) << levels) + 1);
        rows * columns
    };
    let fit = |levels: &u32| points(*levels) <= u128::from(MAX_POINTS);
    if fit(&nested.levels) {
        return Some(());
    }
    let most = (0..nested.levels).rev().find(fit);
    let remedy = match most.filter(|most| *most > 0) {
        Some(most) => format!("set levels = {most} or less"),
        None => "use a coarser grid".to_owned(),
    };
    let many = points(nested.levels);
    let message = format!("the finest grid would have {many} points");
    section
        .fault(DiagnosticKind::GridTooLarge, "levels", message)
        .label("too many halvings")
        .accepted(format!(
            "at most {MAX_POINTS} points, even if few of them are computed"
        ))
        .remedy(remedy)
        .fail(section.issues)
}
