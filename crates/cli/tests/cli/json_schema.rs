//! As much of JSON Schema as the program's schemas use; another keyword is a panic, so that nothing is passed over.

use serde_json::Value;

/// What a document has that its schema does not allow, each with its path.
pub(crate) fn faults(schema: &Value, document: &Value) -> Vec<String> {
    let mut faults = Vec::new();
    check(schema, schema, document, "", &mut faults);
    faults
}

fn check(root: &Value, schema: &Value, value: &Value, path: &str, faults: &mut Vec<String>) {
    let Some(keywords) = schema.as_object() else {
        assert_eq!(schema, true, "{path}");
        return;
    };
    let mut fault = |what: String| faults.push(format!("{path}: {what}"));
    for (keyword, argument) in keywords {
        match keyword.as_str() {
            "type" => {
                let types = argument
                    .as_array()
                    .map_or(std::slice::from_ref(argument), Vec::as_slice);
                if !types
                    .iter()
                    .any(|kind| is_of_type(value, kind.as_str().unwrap()))
                {
                    fault(format!("{value} is not {argument}"));
                }
            }
            "const" if value != argument => fault(format!("{value} is not {argument}")),
            "enum" if !argument.as_array().unwrap().contains(value) => {
                fault(format!("{value} is none of {argument}"));
            }
            "minItems"
                if value
                    .as_array()
                    .is_some_and(|a| (a.len() as u64) < argument.as_u64().unwrap()) =>
            {
                fault("too short".to_owned());
            }
            "maxItems"
                if value
                    .as_array()
                    .is_some_and(|a| (a.len() as u64) > argument.as_u64().unwrap()) =>
            {
                fault("too long".to_owned());
            }
            "minimum"
                if value
                    .as_f64()
                    .is_some_and(|x| x < argument.as_f64().unwrap()) =>
            {
                fault(format!("{value} is less than {argument}"));
            }
            "maximum"
                if value
                    .as_f64()
                    .is_some_and(|x| x > argument.as_f64().unwrap()) =>
            {
                fault(format!("{value} is more than {argument}"));
            }
            "required" => {
                let names = argument
                    .as_array()
                    .unwrap()
                    .iter()
                    .map(|name| name.as_str().unwrap());
                for name in names.filter(|&name| value.is_object() && value.get(name).is_none()) {
                    fault(format!("`{name}` is missing"));
                }
            }
            _ => {}
        }
    }
    for (keyword, argument) in keywords {
        let one = |schema: &Value| {
            let mut faults = Vec::new();
            check(root, schema, value, path, &mut faults);
            faults
        };
        match keyword.as_str() {
            "$ref" => {
                let pointer = argument.as_str().unwrap().strip_prefix('#').unwrap();
                check(root, root.pointer(pointer).unwrap(), value, path, faults);
            }
            "anyOf" | "oneOf" => {
                let of_each: Vec<Vec<String>> =
                    argument.as_array().unwrap().iter().map(one).collect();
                if !of_each.iter().any(Vec::is_empty) {
                    faults.push(format!("{path}: {value} is nothing of {of_each:?}"));
                }
            }
            "items" => {
                for (i, item) in value.as_array().into_iter().flatten().enumerate() {
                    check(root, argument, item, &format!("{path}[{i}]"), faults);
                }
            }
            "properties" | "additionalProperties" => {
                let named = &schema["properties"];
                for (name, field) in value.as_object().into_iter().flatten() {
                    let path = format!("{path}.{name}");
                    match (keyword.as_str(), named.get(name)) {
                        ("properties", Some(schema)) => check(root, schema, field, &path, faults),
                        ("additionalProperties", None) if argument == false => {
                            faults.push(format!("{path} is unknown"));
                        }
                        ("additionalProperties", None) => {
                            check(root, argument, field, &path, faults);
                        }
                        _ => {}
                    }
                }
            }
            "type" | "const" | "enum" | "minItems" | "maxItems" | "minimum" | "maximum"
            | "required" => {}
            "minProperties" | "maxProperties" => {}
            "$schema" | "$defs" | "title" | "description" | "default" | "format" => {}
            other => panic!("{path}: keyword {other}"),
        }
    }
}

fn is_of_type(value: &Value, kind: &str) -> bool {
    match kind {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "number" => value.is_number(),
        "integer" => value.is_u64() || value.is_i64(),
        "boolean" => value.is_boolean(),
        "null" => value.is_null(),
        other => panic!("type {other}"),
    }
}
