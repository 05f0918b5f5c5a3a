"""Validates YAML graphs against a JSON Schema: validate.py SCHEMA GRAPH...; the exit code counts those not valid."""

import json
import sys

try:
    import jsonschema
    import yaml
except ImportError:
    sys.exit(255)


def main():
    with open(sys.argv[1], encoding="utf-8") as stream:
        schema = json.load(stream)
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    bad = 0
    for name in sys.argv[2:]:
        with open(name, encoding="utf-8") as stream:
            graph = yaml.safe_load(stream)
        errors = list(validator.iter_errors(graph))
        for error in errors:
            print(f"{name}: {error.json_path}: {error.message}")
        bad += len(errors) > 0
    return bad


sys.exit(main())
