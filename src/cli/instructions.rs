//! `atlas instructions`: what results are computed with on this machine.

use super::answer;
use crate::propagate;
use clap::Args;
use std::process::ExitCode;

/// Arguments of `atlas instructions`: none.
#[derive(Debug, Args)]
pub struct InstructionsArgs {}

/// Prints the instruction set.
pub fn run(_: &InstructionsArgs) -> ExitCode {
    answer(
        &format!("{}\n", propagate::instructions()),
        ExitCode::SUCCESS,
    )
}
