"""Validates YAML graphs against a JSON Schema: validate.py SCHEMA GRAPH...; exit code 1 where one is not valid."""

import json
import sys

try:
    import jsonschema
    import yaml
except ImportError:
    sys.exit(2)


def main():
    with open(sys.argv[1], encoding="utf-8") as stream:
        schema = json.load(stream)
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    bad = False
    for name in sys.argv[2:]:
        with open(name, encoding="utf-8") as stream:
            graph = yaml.safe_load(stream)
        for error in validator.iter_errors(graph):
            print(f"{name}: {error.json_path}: {error.message}")
            bad = True
    return 1 if bad else 0


sys.exit(main())
