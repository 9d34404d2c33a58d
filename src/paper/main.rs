//! `atlas-paper` times the paper's kernels on its cases, and checks them as `atlas verify` checks the kernels of
//! `atlas`.

// This program prints its results.
#![allow(clippy::print_stdout, clippy::print_stderr)]

// The crate name in the file that is shared with the benches.
extern crate gearatlas_core as gearatlas;

mod ladder;

use clap::{Parser, Subcommand, builder::PossibleValuesParser};
use gearatlas_paper::verify;
use gearatlas_verify::verify::{Check, Extent};
use std::process::ExitCode;

/// Time and check the kernels of the paper from which atlas started
#[derive(Parser)]
#[command(version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Time every kernel on the cases of the paper, count its operations, and print JSON
    Ladder {
        /// Time only these parts [default: all]
        #[arg(value_name = "PART", value_parser = PossibleValuesParser::new(ladder::names()))]
        parts: Vec<String>,
    },
    /// Check every kernel against independent integrators and closed forms: status 0 if all lines pass, 1 if one fails
    Verify {
        /// Use longer horizons and more cycles per drive: many minutes instead of seconds
        #[arg(long)]
        full: bool,
        /// Run only this check; repeat the option for several [default: all]
        #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(verify::CHECKS))]
        only: Vec<String>,
        /// Print JSON instead of text
        #[arg(long)]
        json: bool,
    },
}

fn main() -> ExitCode {
    match Arguments::parse().command {
        Command::Ladder { parts } => {
            println!("{:#}", ladder::measure(&parts));
            ExitCode::SUCCESS
        }
        Command::Verify { full, only, json } => check(full, &only, json),
    }
}

fn check(full: bool, only: &[String], json: bool) -> ExitCode {
    let extent = if full { Extent::Full } else { Extent::Quick };
    let wanted = |check: &Check| only.is_empty() || only.iter().any(|name| name == check.name);
    let checks: Vec<Check> = verify::checks().filter(wanted).collect();
    let report = match verify::run(extent, &checks, &mut |check| eprintln!("{}", check.name)) {
        Ok(report) => report,
        Err(trouble) => {
            eprintln!("atlas-paper: {trouble}");
            return ExitCode::from(1);
        }
    };
    if json {
        println!("{:#}", serde_json::json!({ "checks": report.findings }))
    } else {
        print!("{report}")
    }
    ExitCode::from(report.status())
}
