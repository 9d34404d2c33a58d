use super::*;

const PLENTY: Limits = Limits {
    memory: 64 << 30,
    processors: usize::MAX,
    huge_pages: true,
};

fn planned(description: &str, extent: Extent, limits: Limits) -> Plan {
    let mut topology = Topology::synthetic(description).unwrap();
    // Synthetic caches have sizes only where they are given.
    topology.caches.retain(|cache| cache.size > 0);
    plan(&topology, extent, limits)
}

/// Threads of the stream teams of a placement.
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
    // One thread, all cores and all threads sit alike in both.
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
    let tables: Vec<&str> = (plan.items.iter())
        .filter_map(|item| match item {
            Item::Solver {
                solver: Solver::Spectral,
                modes: 40,
                sharing,
                teams,
            } => {
                assert_eq!(teams.iter().map(Vec::len).collect::<Vec<_>>(), counts);
                Some(sharing.name())
            }
            _ => None,
        })
        .collect();
    assert_eq!(tables, ["shared", "node", "eight"]);
    // Of 28 cores 16 hand lines to each other; nothing else is left out.
    let of: Vec<&[Part]> = plan.missing.iter().map(|missing| missing.of).collect();
    assert_eq!(of, [&[Part::Transfer]], "{:?}", plan.missing);
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

/// STREAM's rule counts the caches of both sockets where threads are on both.
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
            Item::Mixes { lines, .. } => 3 * lines * LINE,
            Item::Mountain { lines, .. } => lines * LINE,
            Item::Latency { sizes, .. }
            | Item::Parallel { sizes, .. }
            | Item::Percentiles { sizes, .. } => sizes[sizes.len() - 1] * LINE,
            Item::Operators {
                dimension, counts, ..
            } => 8 * dimension * dimension.next_multiple_of(8) * counts[counts.len() - 1],
            _ => 0,
        };
        assert!(bytes <= 16 << 20, "{item:?}");
    }
    let all: Vec<&str> = plan.missing.iter().map(|missing| &*missing.said).collect();
    let said = all.join("\n");
    for words in [
        "four times the last-level caches",
        "last-level cache",
        "a table a node",
        "MiB of tables",
        "loads on huge pages",
        "nobody to load it",
        "from core to core",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
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
fn sizes_grow_by_equal_ratios_in_whole_pieces() {
    let found: Vec<u64> = sizes(8 << 10, 64 << 10, 2).collect();
    assert_eq!(
        found,
        [8192, 11_648, 16_384, 23_232, 32_768, 46_400, 65_536]
    );
    let operators: Vec<u64> = sizes(1000, 8000, 2).collect();
    assert_eq!(operators, [1000, 2000, 3000, 4000, 6000, 8000]);
}

/// What is not asked for is not missing.
#[test]
fn parts_are_asked_for() {
    let plan = planned("pu:1", Extent::Quick, PLENTY);
    let (items, missing) = plan.clone().only(&[Part::Latency]);
    assert!(!items.is_empty() && items.iter().all(|item| item.part() == Part::Latency));
    assert!(
        missing.iter().all(|said| !said.contains("a table a node")),
        "{missing:?}"
    );
    let (items, missing) = plan.clone().only(&[]);
    assert_eq!(
        (items.len(), missing.len()),
        (plan.items.len(), plan.missing.len())
    );
    assert!(missing.iter().any(|said| said.contains("a table a node")));
}

fn transfers(plan: &Plan) -> Vec<([u32; 2], Relation)> {
    (plan.items.iter())
        .filter_map(|item| match item {
            Item::Transfer { pair, relation } => Some((pair.map(|thread| thread.index), *relation)),
            _ => None,
        })
        .collect()
}

#[test]
fn lines_go_between_all_pairs_of_few_cores() {
    let caches = "package:2 [numa] l3:2(size=36700160) core:2 pu:2";
    let found = transfers(&planned(caches, Extent::Quick, PLENTY));
    let of = |relation| found.iter().filter(move |(_, r)| *r == relation).count();
    // Eight cores: 28 pairs, and the two threads of each.
    assert_eq!(of(Relation::Core), 8);
    assert_eq!(of(Relation::Cache), 4);
    assert_eq!(of(Relation::Package), 8);
    assert_eq!(of(Relation::Machine), 16);
    assert!(found.contains(&([0, 1], Relation::Core)));
    assert!(found.contains(&([0, 2], Relation::Cache)));
    assert!(found.contains(&([2, 4], Relation::Package)));
    assert!(found.contains(&([0, 14], Relation::Machine)));
    assert!(found.iter().all(|([a, b], _)| a < b));
}

#[test]
fn of_many_cores_near_and_far_ones_are_chosen() {
    let plan = planned(
        "package:2 [numa] l3:4(size=36700160) core:8 pu:2",
        Extent::Full,
        PLENTY,
    );
    let found = transfers(&plan);
    assert_eq!(found.len(), 16 * 15 / 2 + 16);
    for relation in Relation::VARIANTS {
        assert!(found.iter().any(|(_, r)| r == relation), "{relation:?}");
    }
    let said = |m: &Missing| m.said.contains("all 64 cores: 16 were chosen");
    assert!(plan.missing.iter().any(said), "{:?}", plan.missing);
}

#[test]
fn one_follows_a_chain_while_all_other_cores_read() {
    let loaded = |description: &str, limits| {
        let plan = planned(description, Extent::Default, limits);
        plan.items.into_iter().find_map(|item| match item {
            Item::Loaded {
                team, lines, array, ..
            } => {
                assert!((lines + array * (team.len() - 1)) * LINE <= limits.memory as usize);
                Some(team.iter().map(|t| t.index).collect::<Vec<_>>())
            }
            _ => None,
        })
    };
    let small = Limits {
        memory: 32 << 20,
        ..PLENTY
    };
    assert_eq!(loaded("core:3 pu:2", PLENTY), Some(vec![0, 2, 4]));
    assert_eq!(loaded("core:1 pu:2", small), Some(vec![0, 1]));
    let quota = Limits {
        processors: 2,
        ..PLENTY
    };
    assert_eq!(loaded("core:3 pu:2", quota), Some(vec![0, 2]));
    assert_eq!(loaded("pu:1", PLENTY), None);
}

#[test]
fn chains_lie_well_inside_of_every_level() {
    let caches = "package:1 l3:1(size=67108864) l2:4(size=1048576) l1d:1(size=65536) core:1 pu:1";
    let plan = planned(caches, Extent::Quick, PLENTY);
    let sizes = plan.items.iter().find_map(|item| match item {
        Item::Parallel { sizes, .. } => Some(sizes.clone()),
        _ => None,
    });
    let kib: Vec<usize> = sizes
        .unwrap()
        .iter()
        .map(|lines| (lines * LINE) >> 10)
        .collect();
    assert_eq!(kib, [32, 256, 8 << 10, 256 << 10]);
}

/// Mixes are measured on one thread and on all.
#[test]
fn mixes_are_measured_at_both_ends() {
    let plan = planned("core:4 pu:2", Extent::Quick, PLENTY);
    let teams = plan.items.iter().filter_map(|item| match item {
        Item::Mixes { team, .. } => Some(team.len()),
        _ => None,
    });
    assert_eq!(teams.collect::<Vec<_>>(), [1, 8]);
    let plan = planned("pu:1", Extent::Quick, PLENTY);
    let mixes = |item: &&Item| matches!(item, Item::Mixes { .. });
    assert_eq!(plan.items.iter().filter(mixes).count(), 1);
}
