// What messages must be like: the schemas that Foxglove publishes, and those that come with our own messages.
import assert from "node:assert/strict";
import Ajv from "ajv";
import * as published from "@foxglove/schemas/jsonschema.js";

const ajv = new Ajv({ strict: false });

/** Checks a message against the schema of its name; one of Foxglove's against Foxglove's own, and against ours too. */
export function check(name, schemaText, message) {
  const schemas = [[`ours ${name}`, () => JSON.parse(schemaText)]];
  if (name.startsWith("foxglove.")) schemas.push([name, () => published[name.slice("foxglove.".length)]]);
  for (const [key, read] of schemas) {
    if (!ajv.getSchema(key)) ajv.addSchema(read(), key);
    const validate = ajv.getSchema(key);
    assert.ok(validate(message), `${key}: ${JSON.stringify(validate.errors)}`);
  }
}

/** Turns the x axis by a quaternion. */
export function turnedAxis({ w, x, y, z }) {
  return [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)];
}
