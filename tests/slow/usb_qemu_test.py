"""A Polhem behind the kernel's own usbfs: boots Debian's kernel in qemu, attaches the emulated device to its vhci-hcd, and runs
the command there, with libusb as it is. docs/howto/usb.md tells how to run it."""
import csv
import json
import lzma
import os
import pathlib
import shutil
import subprocess
import sys
import tarfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "command"))
from harness import ROOT, TACTOR
from usb_test import ENGAGED, FORCE_MAX, FORCE_SLEW, GRAPH, PERIOD, POLHEM, PRESSED

BUILD = pathlib.Path(os.environ.get("TACTOR_BUILD", pathlib.Path(TACTOR).resolve().parents[1]))
BIN = BUILD / "bin"
SLOW = BUILD.parent / "slow"  # the kernel stays there for the next time
GUEST = SLOW / "usb_qemu"
KERNEL = "linux-image-amd64"
MODULES = {"usb-common": "usb/common", "usbcore": "usb/core", "usbip-core": "usb/usbip", "vhci-hcd": "usb/usbip"}
PATIENCE = 1800  # s, for what takes one or two minutes on an idle machine
SKIPPED = 77     # for ctest


def skip(why):
    print(f"skipped: {why}")
    sys.exit(SKIPPED)


def output(*command, **options):
    return subprocess.run(list(map(str, command)), check=True, capture_output=True, text=True, **options).stdout


def find_tools():
    """Paths of what the machine must have; the test is skipped, by name, where one is missing."""
    for tool, package in (("qemu-system-x86_64", "qemu-system-x86"), ("busybox", "busybox-static"), ("apt-get", "apt"),
                          ("dpkg-deb", "dpkg")):
        if shutil.which(tool) is None:
            skip(f"{tool} is missing: apt-get install {package}")
    if subprocess.run(["ldd", shutil.which("busybox")], capture_output=True, check=False).returncode == 0:
        skip("busybox is not static: apt-get install busybox-static")
    for program in (TACTOR, BIN / "tactor-attach-usb"):
        if not pathlib.Path(program).exists():
            skip(f"{program} is not built")


def fetch_kernel():
    """The package of Debian's kernel, from the cache or by apt-get."""
    SLOW.mkdir(parents=True, exist_ok=True)
    try:
        depends = output("apt-cache", "depends", KERNEL, env=dict(os.environ, LC_ALL="C"))
        package = next(line.split()[1] for line in depends.splitlines() if "Depends: linux-image-" in line)
    except (subprocess.CalledProcessError, StopIteration):
        skip(f"apt knows no {KERNEL}: apt-get update")
    if not list(SLOW.glob(f"{package}_*.deb")):
        got = subprocess.run(["apt-get", "download", package], cwd=SLOW, capture_output=True, text=True, check=False)
        if got.returncode != 0:
            skip(f"{package} cannot be fetched: {got.stderr.strip()}")
    return max(SLOW.glob(f"{package}_*.deb"), key=lambda file: file.stat().st_mtime)


def unpack_kernel(package, modules):
    """The kernel's image; its modules that USB needs go into that folder."""
    with subprocess.Popen(["dpkg-deb", "--fsys-tarfile", package], stdout=subprocess.PIPE) as unpacking:
        with tarfile.open(fileobj=unpacking.stdout, mode="r|") as archive:
            for member in archive:
                path = pathlib.PurePosixPath(member.name)
                if path.name.startswith("vmlinuz-"):
                    (GUEST / "vmlinuz").write_bytes(archive.extractfile(member).read())
                name, _, ending = path.name.partition(".")
                if member.isfile() and f"drivers/{MODULES.get(name)}" in str(path.parent) and ending in ("ko", "ko.xz"):
                    data = archive.extractfile(member).read()
                    (modules / f"{name}.ko").write_bytes(lzma.decompress(data) if ending == "ko.xz" else data)
    missing = [name for name in MODULES if not (modules / f"{name}.ko").exists()]
    if missing or not (GUEST / "vmlinuz").exists():
        raise RuntimeError(f"{package} has no {missing or 'vmlinuz'}")


def copy_as_it_is(file, root):
    """To the same path below the root, so that the paths that programs have in them are right."""
    target = root / str(file).lstrip("/")
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy2(file, target)


def copy_build(root):
    """The command, the emulator, our libraries and profiles, and by ldd what they need."""
    files = [BIN / "tactor", BIN / "tactor-attach-usb", *(BUILD / "lib").rglob("*.so")]
    needed = set()
    for file in files:
        copy_as_it_is(file, root)
        for line in output("ldd", file).splitlines():
            needed.update(word for word in line.split() if word.startswith("/"))
    for file in needed | set((BUILD / "profiles/usb").glob("*.yaml")):
        copy_as_it_is(file, root)


def write_inputs(root):
    text = (ROOT / "devices/usb/profiles/polhem.yaml").read_text()
    path = text[text.index("    - [0 s, 0, 0, 20 mm]"):]
    # The machine is slow: a long patience, and a hand that keeps its pose for a while before it presses.
    for old, new in (("report_timeout: 50 ms", "report_timeout: 1 s"), ("hold: 0.5 s", "hold: 4 s"), (path, PRESSED)):
        assert old in text, old
        text = text.replace(old, new)
    (root / "polhem.yaml").write_text(text)
    (root / "graph.yaml").write_text(GRAPH % {
        "device": "type: usb.device, profile: /polhem.yaml, origin: [0, 0, 10 mm]", "duration": "12 s",
        "more": "failure_timeout: 8 s, stuck_after: 0 s"})
    (root / "paths").write_text(f"BIN={BIN}\n")


def pack(root):
    """The root as the kernel unpacks it into memory."""
    names = "\n".join(["."] + [str(path.relative_to(root)) for path in sorted(root.rglob("*"))]) + "\n"
    with open(GUEST / "initrd", "wb") as file:
        subprocess.run(["busybox", "cpio", "-o", "-H", "newc"], cwd=root, input=names.encode(), stdout=file,
                       stderr=subprocess.DEVNULL, check=True)


def boot():
    """Runs the machine to its end; what it sent by its second serial line is unpacked into `out`."""
    subprocess.run([
        "qemu-system-x86_64", "-accel", "tcg", "-cpu", "max", "-smp", "2", "-m", "768", "-kernel", GUEST / "vmlinuz", "-initrd",
        GUEST / "initrd", "-append", "console=ttyS0 rdinit=/init panic=-1 quiet", "-no-reboot", "-nic", "none", "-display",
        "none", "-monitor", "none", "-serial", f"file:{GUEST / 'console.txt'}", "-serial", f"file:{GUEST / 'out.tar.gz'}"],
        stdin=subprocess.DEVNULL, timeout=PATIENCE, check=True)
    with tarfile.open(GUEST / "out.tar.gz", "r:gz") as archive:
        archive.extractall(GUEST / "out")


class UsbInQemu(unittest.TestCase):
    kernel = None  # its package

    @classmethod
    def setUpClass(cls):
        shutil.rmtree(GUEST, ignore_errors=True)
        root = GUEST / "root"
        for folder in ("bin", "modules", "proc", "sys", "dev", "run", "tmp"):
            (root / folder).mkdir(parents=True)
        unpack_kernel(cls.kernel, root / "modules")
        shutil.copy2(shutil.which("busybox"), root / "bin/busybox")
        shutil.copy2(pathlib.Path(__file__).with_name("usb_qemu_init"), root / "init")
        (root / "init").chmod(0o755)
        copy_build(root)
        write_inputs(root)
        pack(root)
        try:
            boot()
        except Exception:
            console = GUEST / "console.txt"
            print(console.read_text(errors="replace")[-4000:] if console.exists() else "the machine said nothing")
            raise

    def said(self, name):
        return (GUEST / "out" / name).read_text(errors="replace")

    def ended(self, step, code):
        self.assertEqual(self.said(f"{step}.code").strip(), str(code), self.said(f"{step}.out") + self.said(f"{step}.err"))
        return self.said(f"{step}.err")

    def summary(self, run):
        return json.loads(self.said(f"{run}/summary.json"))["device"]

    def efforts(self, trace):
        with open(GUEST / "out" / trace, newline="") as file:
            return [[float(row[f"effort_{i}"]) for i in (1, 2, 3)] for row in csv.DictReader(file)
                    if row["effort_3"] is not None]

    def recorded(self, run):
        """Norms of the commanded forces and engagement; the limits were kept at every tick, and it ends with zero."""
        with h5py.File(GUEST / "out" / run / "recording.h5") as file:
            commanded = file["streams/device.commanded/data"][...]
            safety = file["streams/device.safety/data"][...]
        norm = numpy.linalg.norm(commanded["force"], axis=1)
        self.assertTrue(numpy.isfinite(norm).all())
        self.assertLessEqual(norm.max(), FORCE_MAX * (1 + 1e-9))
        self.assertGreater(norm.max(), 0.1)
        elapsed = numpy.minimum(numpy.diff(commanded["valid_ns"]) * 1e-9, 2 * PERIOD)
        change = numpy.linalg.norm(numpy.diff(commanded["force"], axis=0), axis=1)
        self.assertTrue((change <= FORCE_SLEW * elapsed * (1 + 1e-9)).all())
        self.assertEqual(norm[-1], 0)
        self.assertTrue((safety["engagement"] == ENGAGED).any())
        return norm

    def test_the_kernel_lists_the_device_and_so_does_the_command(self):
        self.ended("devices", 0)
        self.assertRegex(self.said("devices.out"), r"polhem: .*, at \d+-1, serial number attached-\d+-1 ")
        # Port 0 is in use (6), at full speed (2).
        self.assertRegex(self.said("vhci.out"), r"hs\s+0000 006 002 ")
        self.ended("absent", 0)
        self.assertNotIn("serial number attached", self.said("absent.out"))

    def test_the_wall_is_felt_through_the_kernel(self):
        self.ended("calibrate", 0)
        self.ended("run", 0)
        norm = self.recorded("felt")
        link = self.summary("felt")["link"]
        print(f"felt: {link['cycles']} cycles, {len(norm)} ticks, at most {norm.max():.3f} N; link {link}")
        self.assertGreater(link["cycles"], 100)
        self.assertEqual(link["reconnects"], 0)
        efforts = self.efforts("first.csv")
        self.assertGreater(max(max(map(abs, row)) for row in efforts), 0.01)
        # 2 A at 53.8 mN m/A, geared 18 to 1 and 10 to 1.
        for axis, limit in enumerate((1.9359, 1.0755, 1.0755)):
            self.assertLessEqual(max(abs(row[axis]) for row in efforts), limit)
        # What its motors held when nobody had it open any more.
        self.assertEqual(efforts[-1], [0, 0, 0])
        self.assertEqual(self.said("first.code").strip(), "0", self.said("first.err"))

    def test_another_device_is_not_taken_for_the_calibrated_one(self):
        error = self.ended("uncalibrated", 2)
        self.assertIn(POLHEM, error)
        self.assertIn("tactor device calibrate", error)

    def test_a_pulled_cable_is_told_and_ends_the_force(self):
        self.ended("calibrate_again", 0)
        error = self.ended("unplugged", 1)
        self.assertIn(POLHEM, error)
        print(f"unplugged: {error.strip()}")
        self.assertIn("no device 1234:0006 on the USB; is it plugged in", error)
        self.assertEqual(self.summary("unplugged")["link"]["errors"]["reset"], 1)
        self.recorded("unplugged")
        self.assertEqual(self.said("second.code").strip(), "0", self.said("second.err"))

    def test_the_kernel_has_nothing_to_complain_of(self):
        said = self.said("dmesg.out")
        self.assertIn("vhci_hcd", said)
        for complaint in ("kernel BUG at", "Oops", "general protection", "unknown pdu", "cannot find a urb"):
            self.assertNotIn(complaint, said)


if __name__ == "__main__":
    try:
        import h5py
        import numpy
    except ImportError:
        skip("h5py is missing: apt-get install python3-h5py")
    find_tools()
    UsbInQemu.kernel = fetch_kernel()
    unittest.main(verbosity=2)
