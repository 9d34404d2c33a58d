//! Checks that results have the same bits for any division of the work and any number of threads.

use super::drives;
use super::drives::default_gears;
use super::gears::differing;
use super::report::drives_of;
use super::{CheckError, Line, Subjects};
use crate::analysis::{MultistabilityConfig, Probes};
use crate::gear::{Flanks, MeshTable, MeshTableInputs};
use crate::numerics::random::PointSeed;

/// Compares the bits of an integration in one part with those of an integration in two parts.
pub fn resumed(subjects: &Subjects) -> Result<Vec<Line>, CheckError> {
    let cycles = subjects.extent.pick(200, 20_000);
    let mut lines = Vec::new();
    for kernel in &subjects.kernels {
        let (mut unequal, mut checked) = (0, 0);
        for case in &subjects.cases {
            let model = case.model()?;
            if !kernel.supports(&model) {
                continue;
            }
            checked += 1;
            let start = drives::rattling(&model)?;
            let whole = kernel.on(&model)?.passage(&start, cycles)?.end;
            let middle = kernel.on(&model)?.passage(&start, cycles / 3)?.end;
            let parts = kernel
                .on(&model)?
                .passage(&middle, cycles - cycles / 3)?
                .end;
            let pairs = whole.state.iter().zip(&parts.state);
            unequal += pairs.filter(|(a, b)| a.to_bits() != b.to_bits()).count();
        }
        lines.push(Line::at_most(
            format!(
                "{}: {cycles} cycles without interruption, {}",
                kernel.name,
                drives_of(checked, subjects.cases.len())
            ),
            "the same, interrupted and resumed",
            unequal as f64,
            0.0,
            "numbers",
        ));
    }
    Ok(lines)
}

/// Runs some work on a pool of `threads` threads.
fn on_threads<T: Send>(
    threads: usize,
    work: impl FnOnce() -> Result<T, CheckError> + Send,
) -> Result<T, CheckError> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()?;
    pool.install(work)
}

/// Compares probes of attractors and a mesh table on one thread with those on three threads.
pub fn threads(subjects: &Subjects) -> Result<Vec<Line>, CheckError> {
    let kernel = subjects.kernel()?;
    let model = subjects.default_drive()?.model()?;
    let config = MultistabilityConfig {
        initial_conditions: subjects.extent.pick(12, 200),
        decades: 2.0,
        transient: 200,
        cycles: 600,
        slice: None,
    };
    let point = PointSeed {
        seed: 1,
        point_id: 0,
    };
    let probes = Probes::new(&model, config, point, true)?;
    let probe = || {
        Ok(postcard::to_stdvec(
            &kernel.on(&model)?.probes(&model, &probes)?,
        )?)
    };
    let (one, three) = (on_threads(1, probe)?, on_threads(3, probe)?);
    let unequal = one.iter().zip(&three).filter(|(a, b)| a != b).count();

    let gears = default_gears()?;
    let flanks = Flanks::new(&gears)?;
    let inputs = MeshTableInputs::of_gears(&gears);
    let build = || Ok(MeshTable::build(&flanks, &inputs, &|_, _| ())?);
    let tables = (on_threads(1, build)?, on_threads(3, build)?);
    Ok(vec![
        Line::at_most(
            format!(
                "{}: {} probes on 1 thread, {} bytes",
                kernel.name,
                config.initial_conditions,
                one.len()
            ),
            "the same on 3 threads",
            (unequal + one.len().abs_diff(three.len())) as f64,
            0.0,
            "bytes",
        ),
        Line::at_most(
            "mesh table of the default pair on 1 thread",
            "the same on 3 threads",
            differing(&tables.0, &tables.1) as f64,
            0.0,
            "numbers",
        ),
    ])
}
