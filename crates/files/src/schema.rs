//! JSON Schemas of the documents, made from the types that read and write them.

use std::borrow::Cow;

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde_json::{Value, json};

use crate::{Format, Ordered, value_to_json};

impl Format {
    /// The JSON Schema (draft 2020-12) of a document that is read as `T`.
    pub fn schema<T: JsonSchema>(&self) -> String {
        let settings = SchemaSettings::draft2020_12().for_deserialize();
        let mut schema = self.root::<T>(settings);
        schema["properties"]["$schema"] =
            json!({ "description": "A schema, for editors; it is ignored.", "type": "string" });
        value_to_json(&schema)
    }

    /// The JSON Schema of a document that is written as `T`: it has no fields but those.
    pub fn schema_of_result<T: JsonSchema>(&self) -> String {
        let settings = SchemaSettings::draft2020_12().for_serialize();
        let mut schema = self.root::<T>(settings);
        close(&mut schema);
        value_to_json(&schema)
    }

    fn root<T: JsonSchema>(&self, settings: SchemaSettings) -> Value {
        let mut schema = Value::from(settings.into_generator().into_root_schema_for::<T>());
        schema["title"] = json!(self.name);
        let properties = &mut schema["properties"];
        properties["format"] = json!({ "const": self.name });
        properties["version"] = json!({ "const": self.version });
        schema
    }
}

/// Refuses other fields than those named, at every depth.
fn close(schema: &mut Value) {
    match schema {
        Value::Object(fields) => {
            if fields.get("properties").is_some_and(Value::is_object)
                && !fields.contains_key("additionalProperties")
            {
                fields.insert("additionalProperties".to_owned(), Value::Bool(false));
            }
            fields.values_mut().for_each(close);
        }
        Value::Array(items) => items.iter_mut().for_each(close),
        _ => {}
    }
}

/// The schema of a text or null that must not be left out.
pub fn nullable_text(_: &mut SchemaGenerator) -> Schema {
    json_schema!({ "type": ["string", "null"] })
}

impl<T: JsonSchema> JsonSchema for Ordered<T> {
    fn schema_name() -> Cow<'static, str> {
        format!("Map_of_{}", T::schema_name()).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "object", "additionalProperties": generator.subschema_for::<T>() })
    }
}
