//! Every topic and field that the shipped Foxglove layout plots is in the archive's schemas.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

mod common;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use archive::schema::Layout;
use common::recording;
use serde_json::Value;

/// The fields of each topic, as the schemas in a written archive have them.
fn fields_of_an_archive() -> BTreeMap<String, BTreeSet<String>> {
    let bytes = recording(0..100, 10);
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let described = summary.channels.values().map(|channel| {
        assert_eq!(channel.message_encoding, "cdr");
        let schema = channel.schema.as_ref().unwrap();
        assert_eq!(schema.encoding, "ros2msg");
        let layout = Layout::parse(std::str::from_utf8(&schema.data).unwrap()).unwrap();
        (channel.topic.clone(), layout.fields.into_iter().map(|field| field.name).collect())
    });
    described.collect()
}

/// Every message path of a layout, wherever it stands.
fn message_paths(layout: &Value, paths: &mut Vec<String>) {
    match layout {
        Value::String(text) if text.starts_with('/') => paths.push(text.clone()),
        Value::Array(items) => items.iter().for_each(|item| message_paths(item, paths)),
        Value::Object(entries) => entries.values().for_each(|entry| message_paths(entry, paths)),
        _ => {}
    }
}

/// Topic and field of a path such as `/health{process==1}.latency_ns`, and the field that its filter asks.
fn parts(path: &str) -> (String, Vec<String>) {
    let (head, filter) = match path.split_once('{') {
        Some((topic, rest)) => {
            let (filter, field) = rest.split_once('}').unwrap();
            (format!("{topic}{field}"), Some(filter.split(['=', '<', '>', '!']).next().unwrap().to_owned()))
        }
        None => (path.to_owned(), None),
    };
    let (topic, field) = head.split_once('.').map_or((head.as_str(), None), |(topic, field)| (topic, Some(field)));
    (topic.to_owned(), field.map(str::to_owned).into_iter().chain(filter).collect())
}

#[test]
fn the_foxglove_layout_plots_what_an_archive_holds() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../viewers/foxglove/haptic-camera.json");
    let layout: Value = serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap();
    let known = fields_of_an_archive();
    let mut paths = Vec::new();
    message_paths(&layout["configById"], &mut paths);
    assert!(paths.len() > 20, "{paths:?}");
    for path in &paths {
        let (topic, fields) = parts(path);
        let there = known.get(&topic).unwrap_or_else(|| panic!("{path}: no topic {topic} among {:?}", known.keys()));
        for field in fields {
            assert!(there.contains(&field), "{path}: no field {field} in {there:?}");
        }
    }
    for (unplotted, field) in [("/sample", "torque_mnm"), ("/fit", "inertia.ci95_low"), ("/status", "missed_ticks")] {
        assert!(paths.iter().any(|path| *path == format!("{unplotted}.{field}")), "{unplotted}.{field} is not plotted");
    }
}

#[test]
fn every_panel_of_the_foxglove_layout_has_a_place() {
    fn panels(node: &Value, found: &mut BTreeSet<String>) {
        match node {
            Value::String(panel) => assert!(found.insert(panel.clone()), "{panel} twice"),
            node => ["first", "second"].iter().for_each(|side| panels(&node[side], found)),
        }
    }
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../viewers/foxglove/haptic-camera.json");
    let layout: Value = serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap();
    let mut placed = BTreeSet::new();
    panels(&layout["layout"], &mut placed);
    let configured: BTreeSet<String> = layout["configById"].as_object().unwrap().keys().cloned().collect();
    assert_eq!(placed, configured);
}
