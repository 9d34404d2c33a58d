//! Did other programs use the machine while it was measured?
//!
//! The evidence is the ticks of usable processors (`/proc/stat`) minus those of this process, the time that the
//! hypervisor gave to others, the load average, and the scatter of the repetitions of a measurement.

use crate::store::Noise;
use std::fs;

/// Largest fraction of the processor time that other programs may use on a quiet machine.
const MOST_OTHERS: f64 = 0.02;

/// Largest fraction of the processor time that the hypervisor may take on a quiet machine.
const MOST_STOLEN: f64 = 0.01;

/// Largest relative distance of the median repetition from the best one on a quiet machine.
const MOST_SCATTER: f64 = 0.05;

/// Time spent until now, in ticks of all usable processors.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct ProcessorTimes {
    /// All ticks.
    all: u64,
    /// Ticks in which any program ran.
    busy: u64,
    /// Ticks that the hypervisor took.
    stolen: u64,
    /// Ticks of this process.
    this_process: u64,
}

/// Observes the machine from its creation on.
#[derive(Debug)]
pub struct NoiseMonitor {
    threads: Vec<u32>,
    start: Option<ProcessorTimes>,
    load: Option<f64>,
}

impl NoiseMonitor {
    /// Starts to observe hardware threads.
    pub fn new(threads: Vec<u32>) -> Self {
        let load = fs::read_to_string("/proc/loadavg").ok();
        Self {
            start: now(&threads),
            load: load.and_then(|text| text.split_whitespace().next()?.parse().ok()),
            threads,
        }
    }

    /// The observations. `scatter` is the scatter of all measurements, `None` without repetitions.
    pub fn end(&self, scatter: Option<f64>) -> Noise {
        Noise {
            load: self.load,
            ..verdict(self.start.zip(now(&self.threads)), scatter)
        }
    }
}

fn now(threads: &[u32]) -> Option<ProcessorTimes> {
    let processors = fs::read_to_string("/proc/stat").ok()?;
    let stat = fs::read_to_string("/proc/self/stat").ok()?;
    Some(ProcessorTimes {
        this_process: process_ticks(&stat)?,
        ..of_processors(&processors, threads)?
    })
}

/// Ticks of some processors in the text of `/proc/stat`. Its columns are user, nice, system, idle, iowait,
/// irq, softirq, steal; guests are part of user.
fn of_processors(text: &str, threads: &[u32]) -> Option<ProcessorTimes> {
    let mut accounts = ProcessorTimes::default();
    let mut processes = 0;
    for line in text.lines() {
        let mut words = line.split_whitespace();
        let number = words.next().and_then(|name| name.strip_prefix("cpu"));
        let Some(thread) = number.and_then(|number| number.parse::<u32>().ok()) else {
            continue;
        };
        if !threads.contains(&thread) {
            continue;
        }
        let ticks: Vec<u64> = words.flat_map(str::parse).take(8).collect();
        let [user, nice, system, idle, iowait, irq, softirq, stolen] = ticks[..] else {
            return None;
        };
        let busy = user + nice + system + irq + softirq;
        accounts.busy += busy;
        accounts.stolen += stolen;
        accounts.all += busy + stolen + idle + iowait;
        processes += 1;
    }
    (processes > 0).then_some(accounts)
}

/// Ticks of a process in the text of its `stat`: the sum of user and system, which follow the name in
/// parentheses.
fn process_ticks(text: &str) -> Option<u64> {
    let (_, rest) = text.rsplit_once(')')?;
    let mut fields = rest.split_whitespace().skip(11);
    let (user, system): (u64, u64) = (fields.next()?.parse().ok()?, fields.next()?.parse().ok()?);
    Some(user + system)
}

fn verdict(between: Option<(ProcessorTimes, ProcessorTimes)>, scatter: Option<f64>) -> Noise {
    let part = |pick: fn(&ProcessorTimes) -> f64| {
        let (start, end) = between?;
        let all = end.all.checked_sub(start.all).filter(|all| *all > 0)?;
        Some(((pick(&end) - pick(&start)) / all as f64).max(0.0))
    };
    let others = part(|a| a.busy as f64 - a.this_process as f64);
    let stolen = part(|a| a.stolen as f64);
    let mut remarks = Vec::new();
    let mut notice = |value: Option<f64>, most: f64, words: fn(f64) -> String| {
        let noticed = value.filter(|value| *value > most);
        remarks.extend(noticed.map(words));
        noticed.is_none()
    };
    let quiet = [
        notice(others, MOST_OTHERS, |v| {
            format!("other programs took {:.0} % of the processors", 100.0 * v)
        }),
        notice(stolen, MOST_STOLEN, |v| {
            format!(
                "the hypervisor kept {:.0} % of the processors for others",
                100.0 * v
            )
        }),
        notice(scatter, MOST_SCATTER, |v| {
            format!(
                "the median repetition is {:.0} % slower than the best",
                100.0 * v
            )
        }),
    ];
    if between.is_none() {
        remarks.push(
            "the system does not report whether other programs used the processors".to_owned(),
        );
    }
    Noise {
        others,
        stolen,
        load: None,
        scatter,
        quiet: quiet == [true; 3] && between.is_some(),
        remarks,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STAT: &str = "cpu  99 99 99 99 99 99 99 99 0 0\n\
        cpu0 100 10 20 1000 5 1 2 7 0 0\n\
        cpu1 200 0 30 900 0 0 0 3 0 0\n\
        cpu7 9 9 9 9 9 9 9 9 0 0\nintr 12\n";

    #[test]
    fn accounts_are_of_the_processors_in_use() {
        let found = of_processors(STAT, &[0, 1]).unwrap();
        assert_eq!(found.busy, 133 + 230);
        assert_eq!(found.stolen, 10);
        assert_eq!(found.all, 133 + 230 + 10 + 1005 + 900);
        assert_eq!(of_processors(STAT, &[3]), None);
        assert_eq!(of_processors("cpu0 1 2 3", &[0]), None);
        let stat = "12 (a name) with) R 1 1 1 0 -1 0 0 0 0 0 500 30 0 0 20";
        assert_eq!(process_ticks(stat), Some(530));
    }

    #[test]
    fn a_shared_machine_is_said_to_be_shared() {
        let start = ProcessorTimes::default();
        let end = ProcessorTimes {
            all: 1000,
            busy: 900,
            stolen: 30,
            this_process: 500,
        };
        let noise = verdict(Some((start, end)), Some(0.2));
        assert!(!noise.quiet);
        assert_eq!((noise.others, noise.stolen), (Some(0.4), Some(0.03)));
        let all_remarks = noise.remarks.join("; ");
        for words in ["40 %", "3 %", "20 % slower"] {
            assert!(all_remarks.contains(words), "{all_remarks}");
        }
        let alone = ProcessorTimes {
            this_process: 900,
            stolen: 0,
            ..end
        };
        let noise = verdict(Some((start, alone)), Some(0.01));
        assert!(noise.quiet && noise.remarks.is_empty(), "{noise:?}");
        assert!(!verdict(None, None).quiet);
    }

    #[test]
    fn this_process_s_own_work_is_not_noise() {
        let before = now(&[0, 1]);
        if let Some(before) = before {
            let after = now(&[0, 1]).unwrap();
            assert!(after.this_process >= before.this_process && after.all >= before.all);
        }
    }
}
