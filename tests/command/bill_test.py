"""The bill of materials (scripts/sbom): its form is that of SPDX 2.3, and it says what the build and this machine are made of."""
import hashlib
import importlib.util
import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

from harness import HAS_MESHES, HAS_VIEW, ROOT, VERSION

BUILD = pathlib.Path(os.environ.get("TACTOR_BUILD", ROOT / "build/release"))
COMPONENTS = {"tactor": "runtime", "tactor-cgal": "cgal", "tactor-suitesparse": "suitesparse", "tactor-mujoco": "mujoco", "libtactor-dev": "dev", "python3-tactor": "python"}
# Of the specification of SPDX 2.3, what a bill like ours may hold.
RELATIONS = {"DESCRIBES", "CONTAINS", "DEPENDS_ON", "DYNAMIC_LINK", "STATIC_LINK", "BUILD_DEPENDENCY_OF", "BUILD_TOOL_OF"}
FILE_TYPES = {"SOURCE", "BINARY", "TEXT", "OTHER"}
DIGITS = {"SHA1": 40, "SHA256": 64, "SHA512": 128}


def sbom(*arguments):
    return subprocess.run([ROOT / "scripts/sbom", *map(str, arguments)], capture_output=True, text=True, check=False)


def run(*command):
    return subprocess.run(list(map(str, command)), capture_output=True, text=True, check=True, env=dict(os.environ, LC_ALL="C")).stdout


@unittest.skipUnless(shutil.which("dpkg-deb"), "dpkg is not installed")
@unittest.skipUnless((BUILD / "build.ninja").exists(), "the build is not made by Ninja")
class Bill(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="tactor-bill-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        cls.staged = {}
        for package, component in COMPONENTS.items():
            place = cls.folder / package
            run("cmake", "--install", BUILD, "--component", component, "--prefix", place / "usr")
            if place.exists() and any(p.is_file() for p in place.rglob("*")):
                cls.staged[package] = place
        cls.words = ("--build", BUILD, "--version", VERSION, *(f"{name}={place}" for name, place in cls.staged.items()))
        cls.file = cls.staged["tactor"] / "usr/share/doc/tactor/tactor.spdx.json"
        result = sbom("--out", cls.file, *cls.words)
        assert result.returncode == 0, result.stdout + result.stderr
        cls.bill = json.loads(cls.file.read_text())
        cls.packages = {p["SPDXID"]: p for p in cls.bill["packages"]}
        cls.named = {p["name"]: p for p in cls.bill["packages"]}
        cls.files = {f["SPDXID"]: f for f in cls.bill["files"]}

    def related(self, name, kind):
        """The names of the packages that this relation leads to from a package."""
        own = self.named[name]["SPDXID"]
        return {self.packages[r["relatedSpdxElement"]]["name"] for r in self.bill["relationships"]
                if r["spdxElementId"] == own and r["relationshipType"] == kind and r["relatedSpdxElement"] in self.packages}

    def test_the_document_has_what_the_specification_demands(self):
        bill = self.bill
        self.assertEqual((bill["spdxVersion"], bill["dataLicense"], bill["SPDXID"]), ("SPDX-2.3", "CC0-1.0", "SPDXRef-DOCUMENT"))
        self.assertRegex(bill["documentNamespace"], r"^https://[^#\s]+$")
        self.assertRegex(bill["creationInfo"]["created"], r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ$")
        for creator in bill["creationInfo"]["creators"]:
            self.assertRegex(creator, r"^(Person|Organization|Tool): .+")
        identifiers = [bill["SPDXID"], *(element["SPDXID"] for part in ("packages", "files") for element in bill[part])]
        self.assertEqual(len(identifiers), len(set(identifiers)))
        for identifier in identifiers:
            self.assertRegex(identifier, r"^SPDXRef-[A-Za-z0-9.-]+$")
        for relation in bill["relationships"]:
            self.assertIn(relation["relationshipType"], RELATIONS)
            self.assertLessEqual({relation["spdxElementId"], relation["relatedSpdxElement"]}, set(identifiers))
        self.assertEqual(sorted(bill["documentDescribes"]), sorted(self.named[name]["SPDXID"] for name in self.staged))
        for package in bill["packages"]:
            with self.subTest(package=package["name"]):
                self.assertLessEqual({"name", "versionInfo", "downloadLocation", "filesAnalyzed", "licenseConcluded", "licenseDeclared",
                                      "copyrightText"}, set(package))
                self.assertEqual("packageVerificationCode" in package, package["filesAnalyzed"])
        for element in (*bill["files"], *bill["packages"]):
            for checksum in element.get("checksums", ()):
                self.assertRegex(checksum["checksumValue"], f"^[0-9a-f]{{{DIGITS[checksum['algorithm']]}}}$")
        for file in bill["files"]:
            self.assertRegex(file["fileName"], r"^\./")
            self.assertLessEqual(set(file["fileTypes"]), FILE_TYPES)

    def expressions(self):
        for package in self.bill["packages"]:
            yield from (package["licenseConcluded"], package["licenseDeclared"], *package.get("licenseInfoFromFiles", ()))
        for file in self.bill["files"]:
            yield from (file["licenseConcluded"], *file["licenseInfoInFiles"])

    def test_every_licence_of_no_list_is_told_by_its_text(self):
        used = {word for text in self.expressions() for word in re.findall(r"LicenseRef-[A-Za-z0-9.-]+", text)}
        told = {info["licenseId"]: info["extractedText"] for info in self.bill["hasExtractedLicensingInfos"]}
        self.assertEqual(used, set(told))
        self.assertTrue(all(told.values()))

    @unittest.skipUnless(importlib.util.find_spec("license_expression"), "python3-license-expression is not installed")
    def test_every_expression_is_one_of_spdx(self):
        import license_expression
        known = license_expression.get_spdx_licensing()
        for text in sorted(set(self.expressions()) - {"NOASSERTION"}):
            with self.subTest(text):
                parsed = known.parse(text)
                unknown = [key for key in known.unknown_license_keys(parsed) if not key.startswith("LicenseRef-")]
                self.assertEqual(unknown, [])

    def test_every_file_is_named_with_its_checksums(self):
        for name, folder in self.staged.items():
            own = self.named[name]
            held = [self.files[r["relatedSpdxElement"]] for r in self.bill["relationships"]
                    if r["spdxElementId"] == own["SPDXID"] and r["relationshipType"] == "CONTAINS" and r["relatedSpdxElement"] in self.files]
            said = {file["fileName"]: {c["algorithm"]: c["checksumValue"] for c in file["checksums"]} for file in held}
            there = {"./" + p.relative_to(folder).as_posix(): p.read_bytes() for p in folder.rglob("*")
                     if p.is_file() and not p.is_symlink() and p != self.file}
            self.assertEqual(set(said), set(there))
            for path, data in there.items():
                self.assertEqual(said[path], {"SHA1": hashlib.sha1(data).hexdigest(), "SHA256": hashlib.sha256(data).hexdigest()}, path)
            code = hashlib.sha1("".join(sorted(sums["SHA1"] for sums in said.values())).encode()).hexdigest()
            self.assertEqual(own["packageVerificationCode"]["packageVerificationCodeValue"], code)

    def test_libraries_are_those_that_the_loader_takes(self):
        for name, folder in self.staged.items():
            binaries = [path for path in folder.rglob("*")
                        if path.is_file() and not path.is_symlink() and path.read_bytes()[:4] == b"\x7fELF"]
            loaded = set(re.findall(r"=> (/\S+)", run("ldd", *binaries))) if binaries else set()
            places = {place for path in loaded for place in (path, os.path.realpath(path), "/usr" + path, path.removeprefix("/usr"))}
            # It says which places it does not know, and goes on.
            found = subprocess.run(["dpkg", "-S", *places], capture_output=True, text=True, check=False).stdout if places else ""
            owners = {line.split(":")[0] for line in found.splitlines() if not line.startswith("diversion")}
            self.assertLessEqual(self.related(name, "DYNAMIC_LINK"), owners)
            if loaded:
                self.assertIn("libc6", self.related(name, "DYNAMIC_LINK"))

    def test_debian_packages_have_the_versions_of_this_machine(self):
        debian = [p for p in self.bill["packages"] if p["SPDXID"].startswith("SPDXRef-Debian-")]
        self.assertGreater(len(debian), 20)
        for package in debian:
            self.assertEqual(package["versionInfo"], run("dpkg-query", "-W", "-f", "${Version}", package["name"]).split("\n")[0][:len(package["versionInfo"])])

    @unittest.skipUnless(HAS_MESHES, "this build has no CGAL")
    def test_plugins_under_the_gpl_say_why(self):
        self.assertIn("libcgal-dev", self.related("tactor-cgal", "STATIC_LINK"))
        self.assertEqual(self.named["tactor-cgal"]["licenseConcluded"], "GPL-3.0-or-later")
        # No header of CGAL is compiled into what is under the Apache License.
        linked = self.related("tactor", "STATIC_LINK") | self.related("tactor", "DYNAMIC_LINK")
        self.assertFalse([name for name in linked if name.startswith(("libcgal", "libcholmod"))])
        if "tactor-suitesparse" in self.staged:
            self.assertTrue([name for name in self.related("tactor-suitesparse", "DYNAMIC_LINK") if name.startswith("libcholmod")])
            self.assertEqual(self.named["tactor-suitesparse"]["licenseConcluded"], "GPL-3.0-or-later")

    @unittest.skipUnless(HAS_VIEW, "this build has no view")
    def test_parts_of_the_page_are_named_and_their_licences_are_beside_them(self):
        notices = next(self.staged["tactor"].rglob("third_party.txt")).read_text()
        parts = {self.packages[r["relatedSpdxElement"]]["name"]: self.packages[r["relatedSpdxElement"]] for r in self.bill["relationships"]
                 if r["relationshipType"] == "CONTAINS" and r["relatedSpdxElement"].startswith("SPDXRef-npm-")}
        # What the sources of the page import.
        imported = {name for path in (ROOT / "app/view/page/src").rglob("*.js")
                    for name in re.findall(r"from '((?:@[^/']+/)?[^./'][^/']*)", path.read_text())}
        self.assertEqual(set(parts), imported)
        for name, part in parts.items():
            self.assertIn(f"{name} {part['versionInfo']} ({part['licenseConcluded']})", notices)
            self.assertEqual(part["checksums"][0]["algorithm"], "SHA512")
        self.assertEqual(notices.count("Permission is hereby granted"), len(parts))

    def test_the_same_materials_give_the_same_bill(self):
        self.assertEqual(sbom("--out", self.folder / "again.json", *self.words).returncode, 0)
        self.assertEqual((self.folder / "again.json").read_text(), self.file.read_text())

    def test_packages_that_are_not_as_the_bill_says_are_told(self):
        archives = []
        for name, folder in self.staged.items():
            copy = self.folder / "packed" / name
            shutil.copytree(folder, copy, symlinks=True)
            (copy / "DEBIAN").mkdir()
            depends = ", ".join(sorted(self.related(name, "DYNAMIC_LINK")))
            (copy / "DEBIAN/control").write_text(f"Package: {name}\nVersion: {VERSION}\nArchitecture: all\nMaintainer: nobody <nobody@example.org>\n"
                                                 f"Description: for a test\n" + (f"Depends: {depends}\n" if depends else ""))
            archives.append(self.folder / f"{name}.deb")
            run("dpkg-deb", "--root-owner-group", "-Znone", "-b", copy, archives[-1])
        result = sbom("--check", *archives)
        self.assertEqual(result.returncode, 0, result.stderr)
        copy = self.folder / "packed/tactor"
        changed = next(copy.rglob("duck/scene.yaml"))
        changed.write_text(changed.read_text() + "# changed\n")
        control = (copy / "DEBIAN/control").read_text()
        (copy / "DEBIAN/control").write_text(control.replace("libfmt", "libgmt"))
        run("dpkg-deb", "--root-owner-group", "-Znone", "-b", copy, archives[0])
        said = sbom("--check", *archives)
        self.assertEqual(said.returncode, 1)
        self.assertIn("tactor: ./usr/share/tactor/graphs/duck/scene.yaml\n", said.stderr)
        self.assertRegex(said.stderr, r"tactor: is linked with libfmt\S+, which it does not depend on")
        self.assertEqual(len(said.stderr.splitlines()), 3)


if __name__ == "__main__":
    unittest.main()
