use super::*;

const PLENTY: Limits = Limits {
    memory: 64 << 30,
    processors: usize::MAX,
    huge_pages: true,
};

fn planned(description: &str, extent: Extent, limits: Limits) -> Plan {
    let mut topology = Topology::synthetic(description).unwrap();
    // Synthetic caches have sizes only if the description gives them.
    topology.caches.retain(|cache| cache.size > 0);
    plan(&topology, extent, limits)
}

/// Numbers of threads of the stream teams of a placement.
fn stream_threads(plan: &Plan, wanted: Placement) -> Vec<usize> {
    (plan.items.iter())
        .filter_map(|item| match item {
            Item::Streams {
                placement, team, ..
            } if *placement == wanted => Some(team.len()),
            _ => None,
        })
        .collect()
}

fn node_pairs(plan: &Plan) -> Vec<(u32, u32, usize)> {
    (plan.items.iter())
        .filter_map(|item| match item {
            Item::Nodes { team, memory, .. } => {
                assert!(team.iter().all(|thread| thread.node == team[0].node));
                Some((team[0].node, *memory, team.len()))
            }
            _ => None,
        })
        .collect()
}

#[test]
fn two_sockets_with_second_threads() {
    let two = "package:2 [numa] l3:1(size=36700160) core:14 pu:2";
    let plan = planned(two, Extent::Default, PLENTY);
    // Powers of two, the cores of a node, all cores, all threads.
    let counts = [1, 2, 4, 8, 14, 16, 28, 32, 56];
    assert_eq!(stream_threads(&plan, Placement::Compact), counts);
    // Teams of one thread, of all cores and of all threads are equal in both placements.
    assert_eq!(
        stream_threads(&plan, Placement::Scattered),
        [2, 4, 8, 14, 16, 32]
    );
    assert_eq!(
        node_pairs(&plan),
        [(0, 0, 14), (0, 1, 14), (1, 0, 14), (1, 1, 14)]
    );
    let latencies: Vec<(u32, u32)> = (plan.items.iter())
        .filter_map(|item| match item {
            Item::Latency { thread, memory, .. } => Some((thread.node, *memory)),
            _ => None,
        })
        .collect();
    for pair in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        assert!(latencies.contains(&pair), "{pair:?}");
    }
    let tables = |wanted: Solver| -> Vec<&str> {
        let campaigns = plan.items.iter().filter_map(|item| match item {
            Item::Solver { campaign, teams } if campaign.points == POINTS => {
                assert_eq!(teams.iter().map(Vec::len).collect::<Vec<_>>(), counts);
                Some(campaign)
            }
            _ => None,
        });
        let of = campaigns.filter(|c| c.solver == wanted && c.modes == 40);
        of.map(|campaign| campaign.sharing.name()).collect()
    };
    assert_eq!(tables(Solver::ClosedModes), ["shared", "node", "private"]);
    assert_eq!(tables(Solver::Volterra), ["private"]);
    assert_eq!(breadths(&plan), [1, 64, 512]);
    assert_eq!(plan.missing, []);
}

/// Numbers of operating points per thread for `closed_modes`, in the measurements that vary this number.
fn breadths(plan: &Plan) -> Vec<usize> {
    let campaigns = plan.items.iter().filter_map(|item| match item {
        Item::Solver { campaign, teams } if campaign.points != POINTS => {
            assert!(campaign.modes == 40 && teams.len() <= 2);
            (campaign.solver == Solver::ClosedModes).then_some(campaign.points)
        }
        _ => None,
    });
    campaigns.collect()
}

#[test]
fn threads_are_taken_in_order() {
    let topology = Topology::synthetic("package:2 [numa] core:2 pu:2").unwrap();
    let threads = |placement| -> Vec<u32> {
        let order = order(&topology, placement);
        order.iter().map(|thread| thread.index).collect()
    };
    assert_eq!(threads(Placement::Compact), [0, 2, 4, 6, 1, 3, 5, 7]);
    assert_eq!(threads(Placement::Scattered), [0, 4, 2, 6, 1, 5, 3, 7]);
}

/// STREAM's rule counts the caches of both sockets if threads are on both.
#[test]
fn arrays_outgrow_the_caches_they_pass_through() {
    let plan = planned(
        "package:2 [numa] l3:1(size=36700160) core:4 pu:1",
        Extent::Default,
        PLENTY,
    );
    for item in &plan.items {
        if let Item::Streams {
            placement,
            team,
            lines,
        } = item
        {
            let caches = match (placement, team.len()) {
                (Placement::Compact, 1..=4) => 1,
                _ => 2,
            };
            let array = lines * LINE * team.len();
            let wanted = 4 * caches * 36_700_160;
            assert!(array <= wanted && array > wanted - 64 * LINE, "{team:?}");
        }
    }
}

#[test]
fn one_core_in_a_small_container() {
    let limits = Limits {
        memory: 16 << 20,
        processors: 1,
        huge_pages: false,
    };
    let plan = planned("pu:1", Extent::Quick, limits);
    assert_eq!(stream_threads(&plan, Placement::Compact), [1]);
    assert!(stream_threads(&plan, Placement::Scattered).is_empty());
    assert!(node_pairs(&plan).is_empty());
    for item in &plan.items {
        assert!(!matches!(
            item,
            Item::Latency {
                walk: Walk::HopsHuge,
                ..
            }
        ));
        let bytes = match item {
            Item::Streams { lines, .. } => 3 * lines * LINE,
            Item::MemoryMountain { lines, .. } => lines * LINE,
            Item::Latency { sizes, .. } => sizes[sizes.len() - 1] * LINE,
            _ => 0,
        };
        assert!(bytes <= 16 << 20, "{item:?}");
    }
    let all: Vec<&str> = plan.missing.iter().map(|missing| &*missing.said).collect();
    let said = all.join("\n");
    for words in [
        "four times the last-level caches",
        "last-level cache",
        "a table per node",
        "64 operating points per thread",
        "loads on huge pages",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    assert_eq!(breadths(&plan), [1]);
}

#[test]
fn a_quota_bounds_the_teams() {
    let limits = Limits {
        processors: 3,
        ..PLENTY
    };
    let plan = planned("core:8 pu:2", Extent::Quick, limits);
    assert_eq!(stream_threads(&plan, Placement::Compact), [1, 2, 3]);
    assert!(
        plan.missing
            .iter()
            .any(|m| m.said.contains("3 of 16 threads"))
    );
}

#[test]
fn clusters_of_a_package_are_nodes_of_their_own() {
    let plan = planned("package:1 numa:4 core:2 pu:1", Extent::Quick, PLENTY);
    assert_eq!(node_pairs(&plan).len(), 16);
    assert_eq!(stream_threads(&plan, Placement::Compact), [1, 2, 4, 8]);
}

#[test]
fn sizes_grow_by_equal_ratios_in_whole_lines() {
    let found: Vec<u64> = sizes(8 << 10, 64 << 10, 2).collect();
    assert_eq!(
        found,
        [8192, 11_648, 16_384, 23_232, 32_768, 46_400, 65_536]
    );
}

/// Parts that were not requested are not reported as missing.
#[test]
fn parts_are_asked_for() {
    let plan = planned("pu:1", Extent::Quick, PLENTY);
    let (items, missing) = plan.clone().only(&[Part::Latency]);
    assert!(!items.is_empty() && items.iter().all(|item| item.part() == Part::Latency));
    assert!(
        missing
            .iter()
            .all(|said| !said.contains("a table per node")),
        "{missing:?}"
    );
    let (items, missing) = plan.clone().only(&[]);
    assert_eq!(
        (items.len(), missing.len()),
        (plan.items.len(), plan.missing.len())
    );
    assert!(missing.iter().any(|said| said.contains("a table per node")));
}
