//! The description of an exported run by RO-Crate 1.3, as a Process Run Crate 0.6: which programs made which files out
//! of which, in JSON-LD.

use super::provenance::{Build, Session};
use super::read::RecordedSummary;
use serde_json::{Map, Value, json};

/// The file that has the description.
pub const CRATE_FILE: &str = "ro-crate-metadata.json";

const SPECIFICATION: &str = "https://w3id.org/ro/crate/1.3";
const PROFILE: &str = "https://w3id.org/ro/wfrun/process/0.6";

const COMPLETED: &str = "http://schema.org/CompletedActionStatus";
const FAILED: &str = "http://schema.org/FailedActionStatus";

/// The paper whose method the program implements: a program must have a URL, and it has no other.
const METHOD: &str = "https://doi.org/10.1016/j.rinam.2020.100102";

/// A file of an exported run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CrateFile {
    /// Relative to the root, with `/`.
    pub path: String,
    /// What it is to the run.
    pub role: Role,
    /// In bytes.
    pub size: u64,
    /// In hexadecimal digits.
    pub sha256: String,
}

/// What a file is to a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// The run is computed from it.
    Input,
    /// The run has written it.
    Record,
    /// It was drawn from the records.
    Figure,
    /// It is for readers.
    Words,
}

/// What is described beside the run's own summary.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CrateDescription<'a> {
    /// All files, but the description itself.
    pub files: &'a [CrateFile],
    /// The day of the export, by ISO 8601.
    pub date: &'a str,
    /// Whose run it is.
    pub author: Option<&'a str>,
    /// The licence of the data, as a URL.
    pub license: Option<&'a str>,
}

/// The description of a run.
pub fn ro_crate(run: &RecordedSummary, description: &CrateDescription<'_>) -> Value {
    let files = description.files;
    let of_role = |roles: &[Role]| -> Value {
        let of_role = files.iter().filter(|file| roles.contains(&file.role));
        one_or_all(
            of_role
                .map(|file| reference(&file_id(&file.path)))
                .collect(),
        )
    };
    let licence = description.license.unwrap_or("#licence");
    let mut programs: Vec<Build> = Vec::new();
    let mut program_id = |program: &Build| {
        let known = programs.iter().position(|known| known == program);
        let number = known.unwrap_or_else(|| {
            programs.push(program.clone());
            programs.len() - 1
        });
        format!("#vesica-{}", number + 1)
    };
    let mut actions: Vec<Map<String, Value>> = Vec::new();
    for (number, session) in run.sessions.iter().enumerate() {
        let mut action = action_of(number, session);
        action.insert(
            "instrument".into(),
            reference(&program_id(&session.program)),
        );
        action.insert("object".into(), of_role(&[Role::Input]));
        action.insert("result".into(), of_role(&[Role::Record]));
        actions.push(action);
    }
    if files.iter().any(|file| file.role == Role::Figure) {
        let drawing = json!({
            "@id": "#figures",
            "@type": "CreateAction",
            "name": "Drawing the figures",
            "description": "The figures were drawn from the records when the run was exported",
            "endTime": description.date,
            "actionStatus": COMPLETED,
            "instrument": reference(&program_id(&Build::present())),
            "object": of_role(&[Role::Record]),
            "result": of_role(&[Role::Figure]),
        });
        actions.extend(drawing.as_object().cloned());
    }
    if description.author.is_some() {
        for action in &mut actions {
            action.insert("agent".into(), reference("#author"));
        }
    }
    let mut root = json!({
        "@id": "./",
        "@type": "Dataset",
        "conformsTo": reference(PROFILE),
        "name": format!("A run of vesica: {}", run.scene),
        "description": format!(
            "A vesicle with nematic order inside, simulated by vesica: {}, {} steps. The folder is that of the run: \
             its scene, its tables and its fields",
            run.scene, run.steps
        ),
        "datePublished": description.date,
        "license": reference(licence),
        "hasPart": of_role(&[Role::Input, Role::Record, Role::Figure, Role::Words]),
        "mentions": actions.iter().map(|action| reference(id(action))).collect::<Vec<_>>(),
    });
    let mut graph = vec![
        json!({
            "@id": CRATE_FILE,
            "@type": "CreativeWork",
            "conformsTo": reference(SPECIFICATION),
            "about": reference("./"),
        }),
        Value::Null,
        json!({
            "@id": PROFILE,
            "@type": ["CreativeWork", "Profile"],
            "name": "Process Run Crate",
            "version": "0.6",
        }),
    ];
    if let Some(author) = description.author {
        root["author"] = reference("#author");
        graph.push(json!({ "@id": "#author", "@type": "Person", "name": author }));
    }
    graph[1] = root;
    graph.push(match description.license {
        Some(url) => json!({ "@id": url, "@type": "CreativeWork", "name": url }),
        None => json!({
            "@id": "#licence",
            "@type": "CreativeWork",
            "name": "No licence",
            "description": "No licence is stated: ask those who have published the data",
        }),
    });
    graph.extend(files.iter().map(file_entity));
    graph.extend(programs.iter().enumerate().map(program_entity));
    graph.extend(actions.into_iter().map(Value::Object));
    json!({ "@context": format!("{SPECIFICATION}/context"), "@graph": graph })
}

fn reference(id: &str) -> Value {
    json!({ "@id": id })
}

/// Of several things the list; of one that, as RO-Crate 1.3 recommends.
fn one_or_all(mut values: Vec<Value>) -> Value {
    match values.len() {
        1 => values.remove(0),
        _ => values.into(),
    }
}

/// A time by RFC 3339 with its zone in figures, as the rules of the profile want it.
fn zoned(time: &str) -> String {
    time.strip_suffix('Z')
        .map_or(time.to_owned(), |time| format!("{time}+00:00"))
}

fn id(entity: &Map<String, Value>) -> &str {
    entity.get("@id").and_then(Value::as_str).unwrap_or("")
}

/// What a process did, but for its files and its program.
fn action_of(number: usize, session: &Session) -> Map<String, Value> {
    let what = match number {
        0 => "Running the scene".to_owned(),
        _ => format!("Resuming the run, from step {}", session.from_step),
    };
    let mut words = format!(
        "Steps {} to {}, by the command: {}",
        session.from_step,
        session.to_step,
        session.command.join(" ")
    );
    let threads = session.threads.map(|threads| format!("threads: {threads}"));
    let host = session.host.as_ref().map(|host| format!("host: {host}"));
    let processor = session.processor.as_ref();
    let processor = processor.map(|processor| format!("processor: {processor}"));
    for known in [host, processor, threads].into_iter().flatten() {
        words += &format!("; {known}");
    }
    let mut action = Map::new();
    let mut insert = |key: &str, value: Value| action.insert(key.to_owned(), value);
    insert("@id", format!("#session-{}", number + 1).into());
    insert("@type", "CreateAction".into());
    insert("name", what.into());
    insert("description", words.into());
    insert("startTime", zoned(&session.started).into());
    if let Some(ended) = &session.ended {
        insert("endTime", zoned(ended).into());
    }
    let status = match session.reason.as_deref() {
        Some("done") => COMPLETED,
        reason => {
            insert("error", reason.unwrap_or("it did not end").into());
            FAILED
        }
    };
    insert("actionStatus", status.into());
    action
}

fn file_entity(file: &CrateFile) -> Value {
    json!({
        "@id": file_id(&file.path),
        "@type": "File",
        "name": file.path,
        "description": words_of(file),
        "encodingFormat": format_of(&file.path),
        "contentSize": file.size.to_string(),
        "sha256": file.sha256,
    })
}

fn program_entity((number, program): (usize, &Build)) -> Value {
    let known = |text: &Option<String>| text.clone().unwrap_or_else(|| "unknown".to_owned());
    let changed = match program.changed {
        Some(true) => ", changed",
        _ => "",
    };
    json!({
        "@id": format!("#vesica-{}", number + 1),
        "@type": "SoftwareApplication",
        "name": "vesica",
        "version": program.version,
        "url": METHOD,
        "description": format!(
            "Commit {}{changed}; compiler {}; target {} with {}; {}",
            known(&program.commit),
            known(&program.compiler),
            program.target,
            program.target_features.join(", "),
            program.profile
        ),
    })
}

/// A path as a relative URI.
fn file_id(path: &str) -> String {
    let mut id = String::new();
    for byte in path.bytes() {
        match byte {
            b'/' | b'-' | b'.' | b'_' | b'~' => id.push(byte.into()),
            _ if byte.is_ascii_alphanumeric() => id.push(byte.into()),
            _ => id += &format!("%{byte:02X}"),
        }
    }
    id
}

fn format_of(path: &str) -> &'static str {
    match path.rsplit('.').next() {
        Some("csv") => "text/csv",
        Some("json") => "application/json",
        Some("toml") => "application/toml",
        Some("md") => "text/markdown",
        Some("png") => "image/png",
        Some("svg") => "image/svg+xml",
        Some("vtu" | "pvd") => "application/xml",
        _ => "text/plain",
    }
}

fn words_of(file: &CrateFile) -> &'static str {
    match (file.role, file.path.as_str()) {
        (_, "scene.toml") => "The complete scene",
        (Role::Input, _) => "Values at the nodes, or a mesh, that the scene names",
        (_, "run.json") => "How the run went, by which programs, from which inputs",
        (_, "history.csv") => "Energies, area, volume and the solver's work, step by step",
        (_, "ledger.csv") => "Every term of the energy law, step by step",
        (_, "shape.csv") => "Length, waist and width of the vesicle, step by step",
        (Role::Record, path) if path.ends_with(".pvd") => "The list of the snapshots, for ParaView",
        (Role::Record, path) if path.ends_with(".vtu") => "Fields at one time, for ParaView",
        (Role::Record, _) => "A record of the run",
        (Role::Figure, _) => "A figure, or its data",
        (Role::Words, _) => "How to read and to repeat the run",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::Status;

    #[test]
    fn every_name_in_the_description_is_described() {
        let session = Session {
            started: "2026-11-26T10:00:00Z".into(),
            ended: None,
            reason: Some("killed".into()),
            from_step: 0,
            to_step: 2,
            threads: Some(1),
            command: vec!["vesica".into(), "run".into(), "a.toml".into()],
            host: None,
            processor: None,
            program: Build::present(),
        };
        let run = RecordedSummary {
            scene: "Small".into(),
            status: Status::Done,
            error: None,
            started: session.started.clone(),
            ended: None,
            steps: 3,
            every: 1,
            snapshots: 5,
            inputs: Vec::new(),
            sessions: vec![
                session.clone(),
                Session {
                    reason: Some("done".into()),
                    ..session
                },
            ],
        };
        let file = |path: &str, role| CrateFile {
            path: path.into(),
            role,
            size: 1,
            sha256: "0".into(),
        };
        let files = [
            file("scene.toml", Role::Input),
            file("history.csv", Role::Record),
            file("figures/a b.png", Role::Figure),
            file("README.md", Role::Words),
        ];
        for (author, license) in [
            (None, None),
            (Some("A. Author"), Some("https://example.org")),
        ] {
            let description = CrateDescription {
                files: &files,
                date: "2026-11-26",
                author,
                license,
            };
            let described = ro_crate(&run, &description);
            let graph = described["@graph"].as_array().expect("a list");
            let ids: Vec<&str> = graph.iter().filter_map(|it| it["@id"].as_str()).collect();
            assert_eq!(ids.len(), graph.len());
            let mut names = Vec::new();
            graph
                .iter()
                .for_each(|entity| references(entity, &mut names));
            assert!(names.contains(&"figures/a%20b.png"));
            for name in names {
                let is_known = ids.contains(&name) || name.starts_with("http");
                assert!(is_known, "{name} is not described");
            }
            let find = |id: &str| {
                graph
                    .iter()
                    .find(|it| it["@id"] == id)
                    .expect("it is there")
            };
            assert_eq!(find("#session-1")["error"], "killed");
            assert_eq!(find("#session-2").get("error"), None);
            assert_eq!(find("#session-2")["instrument"]["@id"], "#vesica-1");
        }
    }

    /// The names that an entity refers to.
    fn references<'a>(value: &'a Value, names: &mut Vec<&'a str>) {
        for value in value.as_object().into_iter().flat_map(Map::values) {
            match value {
                Value::Object(only) if only.len() == 1 => {
                    names.extend(only.get("@id").and_then(Value::as_str));
                }
                Value::Array(all) => all.iter().for_each(|one| {
                    names.extend(one.get("@id").and_then(Value::as_str));
                }),
                _ => {}
            }
        }
    }
}
