//! The crate's modules stand on floors: each takes from those below it alone.

use std::path::Path;

/// From the ground up; modules of one line do not know each other.
const FLOORS: &[&[&str]] = &[
    &["vector"],
    &["filter", "statistics"],
    &["samples", "options", "estimate"],
    &["preparation"],
    &["regression"],
    &["uncertainty"],
    &["detents", "karnopp", "quasi_static"],
    &["fit"],
    &["average", "calibration", "checks", "diagnosis", "live"],
];

/// Modules that the code of a file or folder names by their path from the crate's root.
fn imports(path: &Path, found: &mut Vec<String>) {
    if path.is_dir() {
        for entry in std::fs::read_dir(path).expect("a folder can be listed") {
            imports(&entry.expect("an entry").path(), found);
        }
        return;
    }
    let text = std::fs::read_to_string(path).expect("a source is text");
    for line in text.lines().filter(|line| !line.trim_start().starts_with("//")) {
        for after in line.split("crate::").skip(1) {
            let names = after.strip_prefix('{').map_or(after, |list| list.split('}').next().unwrap_or_default());
            let names = if after.starts_with('{') { names.split(", ").collect() } else { vec![names] };
            let module = |name: &str| {
                let end = name.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(name.len());
                name[..end].to_owned()
            };
            found.extend(names.into_iter().map(module));
        }
    }
}

#[test]
fn imports_run_downward_only() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let floor = |module: &str| FLOORS.iter().position(|floor| floor.contains(&module));
    let mut seen = 0;
    for (height, module) in
        FLOORS.iter().enumerate().flat_map(|(height, floor)| floor.iter().map(move |m| (height, *m)))
    {
        let folder = source.join(module);
        let mut found = Vec::new();
        imports(&if folder.is_dir() { folder } else { source.join(format!("{module}.rs")) }, &mut found);
        for import in found.iter().filter(|import| *import != module) {
            if let Some(below) = floor(import) {
                assert!(below < height, "{module} takes from {import}, which does not lie below it");
                seen += 1;
            }
        }
    }
    assert!(seen > 50, "only {seen} imports were seen");
    let modules = std::fs::read_dir(&source).expect("the sources can be listed").count() - 1;
    assert_eq!(modules, FLOORS.iter().map(|floor| floor.len()).sum::<usize>(), "a module stands on no floor");
}
