"""The verb `doctor`: what it tells of this machine, to people and to programs, with and without privileges."""
import ctypes
import json
import os
import resource
import subprocess
import unittest

from harness import TACTOR, CommandTest, tactor

FINDINGS = ["fifo", "memory_lock", "nice", "cores", "preemption", "governor", "throttling", "idle_states",
            "rt_throttling", "cgroup", "timer_slack", "clock_source", "machine"]
GRADES = ["ok", "degraded", "bad"]
PR_CAPBSET_DROP = 24
CAP_IPC_LOCK, CAP_SYS_NICE, CAP_SYS_RESOURCE = 14, 23, 24


def give_privileges_up():
    """In the child, before the command begins: it is left without what real time needs, whoever runs the test."""
    prctl = ctypes.CDLL(None, use_errno=True).prctl
    for capability in (CAP_IPC_LOCK, CAP_SYS_NICE, CAP_SYS_RESOURCE):
        # Refused to those who have no capability to lose.
        prctl(PR_CAPBSET_DROP, capability, 0, 0, 0)
    resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
    resource.setrlimit(resource.RLIMIT_MEMLOCK, (65536, 65536))
    resource.setrlimit(13, (0, 0))  # RLIMIT_NICE, which Python has no name for
    if os.getpriority(os.PRIO_PROCESS, 0) < 0:
        os.setpriority(os.PRIO_PROCESS, 0, 0)  # given by whoever started the tests


def unprivileged(*arguments):
    return subprocess.run([TACTOR, "doctor", "--seconds", "0.2", *arguments], capture_output=True, text=True,
                          preexec_fn=give_privileges_up, timeout=120, check=True)


class Doctor(CommandTest):
    def check_fields(self, diagnosis):
        self.assertEqual([finding["id"] for finding in diagnosis["findings"]], FINDINGS)
        for finding in diagnosis["findings"]:
            self.assertIn(finding["grade"], GRADES)
            self.assertTrue(finding["found"])
            self.assertEqual(bool(finding["cost"]), finding["grade"] != "ok", finding)
            self.assertEqual(bool(finding["remedy"]), finding["grade"] != "ok", finding)
        worst = max((finding["grade"] for finding in diagnosis["findings"]), key=GRADES.index)
        self.assertEqual(diagnosis["grade"], worst)
        self.assertIn(os.uname().release, diagnosis["kernel"])
        self.assertGreater(diagnosis["bookkeeping_ns"], 0)
        # A trial without privileges may be starved on a machine that others load; not all of them.
        self.assertGreaterEqual(max(trial["ticks"] + trial["missed"] for trial in diagnosis["trials"]), 190)
        for trial in diagnosis["trials"]:
            latency = trial["wake_latency_us"]
            self.assertLessEqual(latency["p50"], latency["p99"])
            self.assertLessEqual(latency["p99"], latency["max"])

    def test_programs_get_every_finding_and_the_loops_that_were_tried(self):
        diagnosis = json.loads(self.run_ok("doctor", "--json", "--seconds", "0.2").stdout)
        self.check_fields(diagnosis)
        grades = {finding["id"]: finding["grade"] for finding in diagnosis["findings"]}
        # Asking for SCHED_FIFO gives that, or a lower niceness, or nothing new.
        asked = ["SCHED_FIFO"] if grades["fifo"] == "ok" else ["SCHED_OTHER"] * (grades["nice"] == "ok")
        policies = ["SCHED_OTHER", *asked]
        self.assertEqual([(trial["beside_load"], trial["policy"]) for trial in diagnosis["trials"]],
                         [(load, policy) for load in (False, True) for policy in policies])

    def test_without_privileges_it_says_degraded_and_the_mend(self):
        diagnosis = json.loads(unprivileged("--json").stdout)
        self.check_fields(diagnosis)
        self.assertIn(diagnosis["grade"], ("degraded", "bad"))
        findings = {finding["id"]: finding for finding in diagnosis["findings"]}
        for name, item in (("fifo", "rtprio"), ("memory_lock", "memlock"), ("nice", "nice")):
            self.assertEqual(findings[name]["grade"], "degraded")
            self.assertIn(item, findings[name]["remedy"])
            # Root lacks these inside a container alone, where the limits of a login do not help.
            self.assertIn("--cap-add" if os.geteuid() == 0 else "limits.d", findings[name]["remedy"])
        self.assertEqual({trial["policy"] for trial in diagnosis["trials"]}, {"SCHED_OTHER"})

    def test_people_get_a_table_of_a_hundred_columns(self):
        text = unprivileged().stdout
        self.assertIn("Real time on this machine: degraded", text)
        self.assertNotIn("\x1b", text)
        for word in ("SCHED_FIFO", "refused", "cost", "fix", "clock source", "p99", "The loop itself costs"):
            self.assertIn(word, text)
        for line in text.splitlines():
            self.assertLessEqual(len(line), 100, line)
            self.assertEqual(line, line.rstrip())

    def test_wrong_options_are_exit_code_2(self):
        for arguments in (["--seconds", "0"], ["--seconds", "x"], ["--seconds", "nan"], ["--fast"], ["here"]):
            result = tactor("doctor", *arguments)
            self.assertEqual(result.returncode, 2, f"{arguments}: {result.stdout}{result.stderr}")


if __name__ == "__main__":
    unittest.main()
