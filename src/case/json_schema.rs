//! The keys of a file as a JSON schema (draft 7), by which editors complete, explain and check what is written.
//!
//! It knows each key by itself; what does not fit together, and whether a case that stands on nothing is complete, only
//! `fsi-driver check` can say.

use super::defaults;
use super::load::Preset;
use super::schema::{Choice, Key, Schema, ValueKind};
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;

impl Schema {
    /// The JSON schema of a file with these keys.
    pub fn to_json(&self, title: &str) -> Value {
        let mut root = object(self, "");
        let members = root.as_object_mut().expect("made of a map");
        members.insert(
            "$schema".into(),
            "http://json-schema.org/draft-07/schema#".into(),
        );
        members.insert("title".into(), title.into());
        if self.has_defaults() {
            let properties = members["properties"]
                .as_object_mut()
                .expect("made of a map");
            let tables: Map<_, _> = (properties.keys())
                .map(|name| {
                    (
                        name.clone(),
                        json!({ "$ref": format!("#/properties/{name}") }),
                    )
                })
                .collect();
            let preset = |preset: Preset| {
                let values = json!({
                    "type": "object",
                    "properties": tables.clone(),
                    "additionalProperties": false,
                });
                (preset.name().to_owned(), values)
            };
            let presets: Map<_, _> = Preset::ALL.into_iter().map(preset).collect();
            properties.insert(
                "preset".into(),
                json!({
                    "description": "values that count with --preset",
                    "type": "object",
                    "properties": presets,
                    "additionalProperties": false,
                }),
            );
            properties.insert(
                "extends".into(),
                json!({
                    "description": "the file that this one extends, relative to its own; or \"defaults\", built into the program",
                    "type": "string",
                    "minLength": 1,
                }),
            );
        }
        root
    }
}

/// The table at `path` (empty: the file).
fn object(schema: &Schema, path: &str) -> Value {
    let mut properties = Map::new();
    let mut required = BTreeSet::new();
    let inside = |key: &&Key| match path {
        "" => true,
        _ => key.path.starts_with(&format!("{path}.")),
    };
    for key in schema.keys().iter().filter(inside) {
        let rest = key.path[path.len()..].trim_start_matches('.');
        let name = rest.split(['.', '[']).next().unwrap_or_default();
        if key.table() == path {
            properties.insert(name.to_owned(), property(schema, key));
            if key.absent.is_none() && key.choices.is_empty() {
                required.insert(name.to_owned());
            }
        } else if !properties.contains_key(name) {
            let table = super::schema::join(path, name);
            let value = match rest[name.len()..].starts_with("[]") {
                true => json!({
                    "type": "array",
                    "minItems": 1,
                    "items": object(schema, &format!("{table}[]")),
                }),
                false => object(schema, &table),
            };
            properties.insert(name.to_owned(), value);
            if schema.optional_tables(&key.path).next().is_none() {
                required.insert(name.to_owned());
            }
        }
    }
    let choices = choices(schema, path, &properties);
    let mut table = json!({
        "type": "object",
        "properties": properties,
        "additionalProperties": false,
    });
    // A file that stands on others names what differs.
    if !schema.has_defaults() {
        table["required"] = json!(required);
    }
    if !choices.is_empty() {
        table["allOf"] = json!(choices);
    }
    table
}

/// Where a table makes a choice, it has the keys of that choice only.
fn choices(schema: &Schema, path: &str, properties: &Map<String, Value>) -> Vec<Value> {
    let here: Vec<&Key> = (schema.keys().iter())
        .filter(|key| key.table() == path)
        .collect();
    let mut all: Vec<Choice> = Vec::new();
    for choice in here.iter().flat_map(|key| &key.choices) {
        if !all.contains(choice) {
            all.push(*choice);
        }
    }
    let rule = |choice: Choice| {
        let foreign = |name: &str| {
            let mut keys = here.iter().filter(|key| key.name() == name);
            keys.any(|key| !key.choices.is_empty() && !key.choices.contains(&choice))
        };
        let allowed: Vec<_> = properties.keys().filter(|name| !foreign(name)).collect();
        let mut then = json!({ "propertyNames": { "enum": allowed } });
        if !schema.has_defaults() {
            let needed = here
                .iter()
                .filter(|key| key.choices.contains(&choice) && key.absent.is_none())
                .map(|key| key.name())
                .collect::<Vec<_>>();
            then["required"] = json!(needed);
        }
        json!({
            "if": { "properties": { choice.tag: { "const": choice.word } }, "required": [choice.tag] },
            "then": then,
        })
    };
    all.into_iter().map(rule).collect()
}

/// One key.
fn property(schema: &Schema, key: &Key) -> Value {
    let mut value = match key.kind {
        ValueKind::Real(range) => {
            let low = if range.with_low {
                "minimum"
            } else {
                "exclusiveMinimum"
            };
            json!({ "type": "number", low: range.low, "maximum": range.high })
        }
        ValueKind::Whole(low, high) => whole(low, high),
        ValueKind::Word(words) => {
            let (names, meanings): (Vec<_>, Vec<_>) = words.iter().copied().unzip();
            json!({ "enum": names, "x-taplo": { "docs": { "enumValues": meanings } } })
        }
        ValueKind::Text(most) => json!({ "type": "string", "minLength": 1, "maxLength": most }),
        ValueKind::Flag => json!({ "type": "boolean" }),
        ValueKind::Path | ValueKind::PathOr(_) => json!({ "type": "string", "minLength": 1 }),
        ValueKind::Command(most) => list(1, most, json!({ "type": "string" })),
        ValueKind::Rows(most) => {
            let share = json!({ "type": "number", "minimum": 0, "maximum": 1 });
            list(3, most, list(3, most, share))
        }
        ValueKind::Radii(rows, columns) => list(2, rows, list(4, columns, positive())),
        ValueKind::Triples(most) => list(
            0,
            most,
            list(3, 3, json!({ "type": "integer", "minimum": 0 })),
        ),
        ValueKind::Points(most) => list(0, most, list(3, 3, json!({ "type": "number" }))),
        ValueKind::Degrees(low, high) => {
            json!({ "anyOf": [whole(low, high), list(3, 3, whole(low, high))] })
        }
        ValueKind::WholeOr(low, high, word) => {
            json!({ "anyOf": [whole(low, high), { "const": word }] })
        }
        ValueKind::Sizes(most) => list(1, most, positive()),
        ValueKind::Names(most) => list(1, most, json!({ "type": "string", "minLength": 1 })),
        ValueKind::Numbers(most) => list(2, most, json!({ "type": "number" })),
        ValueKind::Amplitudes(most) => list(1, most, json!({ "type": "number" })),
    };
    let unit = key.unit().map_or(String::new(), |unit| format!(", {unit}"));
    let absent = key
        .absent
        .map_or(String::new(), |absent| format!("; absent: {absent}"));
    value["description"] = format!("{}{unit}{absent}", key.about).into();
    let explained = defaults::explained().get(&key.path);
    if let Some(default) = explained.filter(|_| schema.has_defaults()) {
        value["default"] = json!(default.value);
    }
    value
}

fn list(least: usize, most: usize, items: Value) -> Value {
    json!({ "type": "array", "minItems": least, "maxItems": most, "items": items })
}

fn positive() -> Value {
    json!({ "type": "number", "exclusiveMinimum": 0 })
}

fn whole(low: i64, high: i64) -> Value {
    json!({ "type": "integer", "minimum": low, "maximum": high })
}
