"""A Slurm of a few virtual nodes on this machine, which tests may break: nodes lose power, daemons end and come back.

A daemon `slurmd` stands for each node; it has ports, a spool and a scratch folder of its own. All nodes share this
machine's files, as the nodes of a cluster share a file system. No systemd, no cgroups and no settings of the system
are used, so that several such clusters run beside each other, in a container too. Slurm and munge must be installed
(slurmctld, slurmd, slurm-client and munge of Debian 12), and the caller must be root.
"""
import collections
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import time

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "scancel", "scontrol", "sinfo", "squeue")
# Debian's daemons are not on every user's path.
PATH = os.pathsep.join([os.environ.get("PATH", os.defpath), "/usr/local/sbin", "/usr/sbin", "/sbin"])
PATIENCE = 60  # s, for what takes a moment on an idle machine
LONGEST_FOLDER = 60  # bytes; a socket's path must fit into 107
PORTS = range(20000, 30000)  # below those that the kernel gives to outgoing connections
NODE = "TACTOR_TEST_NODE"  # in the environment of a node's daemon, which its slurmstepd's inherit: the folder of the node
# Of slurm.conf; what is not named here is as Slurm has it.
CONFIGURATION = """
ClusterName=tactor
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
CredType=cred/munge
# A requeued task waits for its credential to expire, which takes 120 s where nothing is set.
AuthInfo=socket={folder}/munge/socket,cred_expire={credential_s}
StateSaveLocation={folder}/state
SlurmctldPidFile={folder}/state/slurmctld.pid
SlurmctldLogFile={folder}/log/slurmctld.log
SlurmctldDebug=verbose
SlurmdSpoolDir={folder}/%n/spool
SlurmdPidFile={folder}/%n/slurmd.pid
SlurmdLogFile={folder}/log/%n.log
SlurmdDebug=verbose
PlugStackConfig={folder}/plugstack.conf
# The output of the script of this name gives a task the TMPDIR of its node.
TaskProlog={folder}/task_prolog
# A machine may have fewer processors than its nodes together.
SlurmdParameters=config_overrides
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/filetxt
JobCompLoc={folder}/log/jobs.txt
MailProg=/bin/true
MpiDefault=none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/backfill
SchedulerParameters=batch_sched_delay=0,sched_interval=1,sched_min_interval=10000,bf_interval=1
# A node that was down is used again as soon as its daemon is back.
ReturnToService=2
JobRequeue=1
MaxArraySize={array_size}
MaxJobCount=10000
# Finished jobs are shown for so long, then forgotten.
MinJobAge={job_age_s}
# From SIGTERM to SIGKILL at the time limit or when cancelled.
KillWait={kill_wait_s}
# A task that is missing on a node which is back counts as lost once it is MessageTimeout older than this.
BatchStartTimeout=1
SlurmdTimeout={node_timeout_s}
SlurmctldTimeout=10
MessageTimeout=5
TCPTimeout=2
InactiveLimit=0
{nodes}
PartitionName=main Nodes=ALL Default=YES MaxTime=60 State=UP
PartitionName=short Nodes=ALL MaxTime=1 State=UP
"""
# Beside slurm.conf. Daemons load a plugin for cgroups though nothing uses it. This one does not look for them; the one that Slurm
# would choose ends slurmd where there are none, as in many containers.
CGROUPS = """
CgroupPlugin=cgroup/v1
CgroupMountpoint={folder}/cgroup
"""
TASK_PROLOG = """#!/bin/sh
echo "export TMPDIR={folder}/$SLURMD_NODENAME/scratch"
"""

Task = collections.namedtuple("Task", "state reason node")


def unavailable():
    """Why no such cluster can be started here; None where one can."""
    missing = [program for program in PROGRAMS if shutil.which(program, path=PATH) is None]
    if missing:
        return f"Slurm is not installed: {', '.join(missing)} missing"
    if os.geteuid() != 0:
        return "only root can start Slurm's daemons"
    return None


def stat(pid):
    """The command, state and parent of a process; None where there is no living process."""
    try:
        text = pathlib.Path(f"/proc/{pid}/stat").read_text(errors="replace")
    except OSError:
        return None
    name, _, rest = text.partition("(")[2].rpartition(")")
    state, parent = rest.split()[:2]
    return None if state in "ZX" else (name, state, int(parent))


def environment_of(pid):
    """The environment with which a process was started; empty where it cannot be read."""
    try:
        entries = pathlib.Path(f"/proc/{pid}/environ").read_bytes().split(b"\0")
    except OSError:
        return {}
    return dict(os.fsdecode(entry).split("=", 1) for entry in entries if b"=" in entry) or environment_by_log(pid)


def environment_by_log(pid):
    """What a slurmstepd was started with, which wipes its environment since Slurm 24: its log is FOLDER/log/NODE.log."""
    if (stat(pid) or [None])[0] != "slurmstepd":
        return {}
    try:
        logs = [log for log in map(pathlib.Path.readlink, pathlib.Path(f"/proc/{pid}/fd").iterdir()) if log.parent.name == "log"]
    except OSError:
        return {}
    return {"SLURM_CONF": str(logs[0].parents[1] / "slurm.conf"), "SLURMD_NODENAME": logs[0].stem} if logs else {}


def processes(belongs):
    """{pid: command} of all living processes whose environment satisfies `belongs`, and of all their descendants."""
    table = {}
    for entry in pathlib.Path("/proc").iterdir():
        if entry.name.isdigit():
            found = stat(entry.name)
            if found is not None:
                table[int(entry.name)] = found
    chosen = {pid for pid in table if belongs(environment_of(pid))}
    grown = True
    while grown:
        more = {pid for pid, (_, _, parent) in table.items() if parent in chosen} - chosen
        chosen |= more
        grown = bool(more)
    return {pid: table[pid][0] for pid in chosen if pid != os.getpid()}


def send(pids, how):
    """Sends a signal to those of these processes that still live."""
    for pid in pids:
        try:
            os.kill(pid, how)
        except ProcessLookupError:
            pass


def kill_all(belongs, timeout=PATIENCE):
    """Ends all these processes with SIGKILL, also those that they start meanwhile.

    All are stopped before the first is killed, since none may see another die: a shell would go on with its next line, and a
    slurmstepd would report a failed task, which a node without power cannot.
    """
    end = time.monotonic() + timeout
    stopped = set()
    while more := set(processes(belongs)) - stopped:
        send(more, signal.SIGSTOP)
        stopped |= more
    # Where many are killed, it takes a moment until the last is gone.
    while found := processes(belongs):
        send(found, signal.SIGKILL)
        if time.monotonic() > end:
            raise TimeoutError(f"these processes do not end: {found}")
        time.sleep(0.01)


def take_port(taken):
    """A port for a daemon, and the lock that keeps it from other clusters of this machine.

    The lock is a socket in the abstract namespace: it goes with its process, and is seen where the port is.
    """
    start = os.getpid() * 37 % len(PORTS)
    for port in (*PORTS[start:], *PORTS[:start]):
        lock = socket.socket(socket.AF_UNIX)
        try:
            lock.bind(f"\0tactor-test-slurm-{port}")
            with socket.socket() as probe:
                probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                probe.bind(("", port))
        except OSError:
            lock.close()
            continue
        taken.append(lock)
        return port
    raise RuntimeError(f"no port is free from {PORTS[0]} to {PORTS[-1]}")


class SlurmCluster:
    """A Slurm that runs as long as its `with` block; nothing of it is left behind, however the block ends.

    folder: holds everything; made where missing, kept afterwards (`log/` tells what happened).
    nodes, cpus: how many nodes, `node0` and so on, and how many tasks of one processor each may run at once.
    array_size: MaxArraySize; the highest index of an array is one less.
    credential_s: how long a requeued task waits at least.
    node_timeout_s: SlurmdTimeout; a node that is silent for so long is down.
    kill_wait_s: KillWait, from SIGTERM to SIGKILL.
    job_age_s: MinJobAge; how long squeue shows a finished job.

    `env` is what a command needs in its environment to use this cluster. A task knows its node by SLURMD_NODENAME, and
    its TMPDIR is the scratch folder of that node.
    """

    def __init__(self, folder, nodes=2, cpus=2, *, array_size=1001, credential_s=5, node_timeout_s=6, kill_wait_s=3,
                 job_age_s=300):
        if credential_s < 5:
            raise ValueError(f"credential_s is {credential_s}; below 5 Slurm takes its own 120 s")
        self.folder = pathlib.Path(folder).resolve()
        if len(os.fsencode(self.folder)) > LONGEST_FOLDER or any(letter.isspace() for letter in str(self.folder)):
            raise ValueError(f"{self.folder}: Slurm needs a folder without spaces and of at most {LONGEST_FOLDER} bytes, "
                             "since sockets are made in it")
        self.names = [f"node{i}" for i in range(nodes)]
        self.cpus = cpus
        self.limits = {"array_size": array_size, "credential_s": credential_s, "node_timeout_s": node_timeout_s,
                       "kill_wait_s": kill_wait_s, "job_age_s": job_age_s}
        self.configuration = self.folder / "slurm.conf"
        self.env = {"SLURM_CONF": str(self.configuration)}
        self.munge = self.controller = self.guard = None
        self.slurmds = [None] * nodes
        self.is_off = [False] * nodes  # its power failed
        self.locks = []

    def __enter__(self):
        reason = unavailable()
        if reason is not None:
            raise RuntimeError(reason)
        if running := processes(self.is_ours):
            raise RuntimeError(f"{self.folder}: another cluster runs in this folder: {running}")
        try:
            self.write_files()
            # Ends the cluster where this process is killed: its input then ends.
            self.guard = subprocess.Popen([sys.executable, __file__, self.folder], stdin=subprocess.PIPE,
                                          stdout=subprocess.DEVNULL, start_new_session=True)
            self.start_munge()
            self.start_controller()
            for i in range(len(self.names)):
                self.start_slurmd(i, wait=False)
            self.wait_nodes()
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        """Ends all daemons and tasks; may be called twice."""
        try:
            kill_all(self.is_ours)
        finally:
            for process in (self.munge, self.controller, *self.slurmds):
                if process is not None:
                    process.wait()
            if self.guard is not None:
                self.guard.stdin.close()
                self.guard.wait()
                self.guard = None
            while self.locks:
                self.locks.pop().close()

    def is_ours(self, environment):
        return environment.get("SLURM_CONF") == str(self.configuration)

    def is_of_node(self, i):
        """Tells by the environment of a process whether it runs on a node: its daemon, or what that started."""
        def belongs(environment):
            return environment.get(NODE) == str(self.folder / self.names[i]) or (
                self.is_ours(environment) and environment.get("SLURMD_NODENAME") == self.names[i])
        return belongs

    def write_files(self):
        for name in ("munge", "state", "log", *(f"{node}/{part}" for node in self.names for part in ("spool", "scratch"))):
            (self.folder / name).mkdir(parents=True, exist_ok=True)
        (self.folder / "plugstack.conf").touch()
        (self.folder / "cgroup.conf").write_text(CGROUPS.format(folder=self.folder))
        prolog = self.folder / "task_prolog"
        prolog.write_text(TASK_PROLOG.format(folder=self.folder))
        prolog.chmod(0o755)
        key = self.folder / "munge/key"
        key.touch(0o600)
        key.write_bytes(os.urandom(128))
        host = socket.gethostname().partition(".")[0]
        nodes = "\n".join(f"NodeName={name} NodeHostname={host} NodeAddr=127.0.0.1 Port={take_port(self.locks)} CPUs={self.cpus} "
                          f"Sockets=1 CoresPerSocket={self.cpus} ThreadsPerCore=1 RealMemory=65536 State=UNKNOWN" for name in self.names)
        self.configuration.write_text(CONFIGURATION.format(
            folder=self.folder, host=host, port=take_port(self.locks), nodes=nodes, **self.limits))

    def environment(self, extra=None):
        """This process's environment without what an outer Slurm or its user set, with this cluster's."""
        kept = {name: value for name, value in os.environ.items()
                if not name.startswith(("SLURM", "SBATCH_", "SQUEUE_", "SCANCEL_", "SINFO_", "SALLOC_", "SRUN_"))}
        return {**kept, "PATH": PATH, **self.env, **(extra or {})}

    def daemon(self, name, *command, **extra):
        """Starts a daemon in the foreground, which a Ctrl-C for the tests does not reach."""
        with open(self.folder / f"log/{name}.start.log", "ab") as log:
            return subprocess.Popen([shutil.which(command[0], path=PATH), *map(str, command[1:])], stdin=subprocess.DEVNULL,
                                    stdout=log, stderr=log, env=self.environment(extra), cwd=self.folder / "log",
                                    start_new_session=True)

    def wait_for(self, condition, what, process=None, timeout=PATIENCE):
        """Waits until `condition()` holds; raises where the daemon ends before, or after `timeout` (s)."""
        end = time.monotonic() + timeout
        while not (result := condition()):
            if process is not None and process.poll() is not None:
                raise RuntimeError(f"the daemon ended before {what}:\n{self.log_tail()}")
            if time.monotonic() > end:
                raise TimeoutError(f"{timeout} s have gone by before {what}:\n{self.log_tail()}")
            time.sleep(0.05)
        return result

    def log_tail(self, lines=8):
        """The last lines of every log."""
        return "\n".join(f"{path.name}: {line}" for path in sorted((self.folder / "log").glob("*.log"))
                         for line in path.read_text(errors="replace").splitlines()[-lines:])

    def start_munge(self):
        """Its key and socket are the cluster's own. `--force`: it warns only where others may look into the folder."""
        place = self.folder / "munge"
        self.munge = self.daemon("munge", "munged", "--foreground", "--force", f"--key-file={place / 'key'}",
                                 f"--socket={place / 'socket'}", f"--pid-file={place / 'pid'}", f"--seed-file={place / 'seed'}",
                                 f"--log-file={self.folder / 'log/munged.log'}")
        self.wait_for(lambda: self.answers(place / "socket"), "munged answered", self.munge)

    @staticmethod
    def answers(path):
        with socket.socket(socket.AF_UNIX) as probe:
            return probe.connect_ex(str(path)) == 0

    def run(self, *command, check=True, timeout=PATIENCE, **options):
        """The finished command, used with this cluster: returncode, stdout, stderr."""
        result = subprocess.run([*map(str, command)], capture_output=True, text=True, timeout=timeout, check=False,
                                env=self.environment(options.pop("env", None)), **options)
        if check and result.returncode != 0:
            raise RuntimeError(f"{' '.join(map(str, command))} ended with exit code {result.returncode}: {result.stdout}{result.stderr}")
        return result

    def start_controller(self):
        """Starts slurmctld, which goes on with the jobs that it knew; returns when it answers."""
        self.controller = self.daemon("slurmctld", "slurmctld", "-D")
        self.wait_for(lambda: "is UP" in self.run("scontrol", "ping", check=False).stdout, "slurmctld answered", self.controller)

    def stop_controller(self, how=signal.SIGTERM):
        """Ends slurmctld: SIGTERM lets it save what it knows, SIGKILL does not. Running tasks go on."""
        self.end(self.controller, how)

    def start_slurmd(self, i, wait=True):
        """Starts the daemon of a node; returns when the node takes tasks, unless told not to wait."""
        # -b: the node has just booted, so that Slurm knows at once that what ran there is lost.
        boots = ["-b"] if self.is_off[i] else []
        self.is_off[i] = False
        self.slurmds[i] = self.daemon(self.names[i], "slurmd", "-D", "-N", self.names[i], *boots,
                                      **{NODE: str(self.folder / self.names[i])})
        if wait:
            self.wait_nodes(i)

    def kill_slurmd(self, i, how=signal.SIGKILL):
        """Ends the daemon of a node alone. Its tasks go on."""
        self.end(self.slurmds[i], how)

    def kill_node(self, i):
        """Ends all that runs on a node at once and without a word, as if its power failed. Its files stay.

        Slurm finds the loss once the node is silent for long enough (9 to 16 s where node_timeout_s is 3, 16 to 18 s where it is 6),
        or when the node is back, where its tasks have run for 7 s or more by then. Lost tasks are queued again, and start
        credential_s + 1 s later.
        """
        kill_all(self.is_of_node(i))
        self.slurmds[i].wait()
        self.is_off[i] = True

    def end(self, process, how):
        process.send_signal(how)
        try:
            process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            raise

    def scratch(self, i):
        """The folder on a node's own disk: the TMPDIR of its tasks."""
        return self.folder / self.names[i] / "scratch"

    def processes_of_node(self, i):
        """{pid: command} of what runs on a node: slurmd, a slurmstepd for each task, and the tasks."""
        return processes(self.is_of_node(i))

    def node_states(self):
        """{name: state}, for example `idle`, `mixed`, `allocated`, `down`; `*` behind it: the node does not answer."""
        lines = self.run("sinfo", "-h", "-N", "-p", "main", "-o", "%N|%T").stdout.splitlines()
        return dict(line.split("|") for line in lines)

    def wait_nodes(self, *which, timeout=PATIENCE):
        """Waits until these nodes, or all, take tasks."""
        ready = {"idle", "mixed", "allocated", "completing"}
        for i in which or range(len(self.names)):
            self.wait_for(lambda name=self.names[i]: self.node_states().get(name) in ready, f"{self.names[i]} took tasks",
                          self.slurmds[i], timeout)

    def queue(self, *options):
        """{job id: Task(state, reason, node)} of all jobs, finished ones too. A task of an array has an id like `7_2`."""
        lines = self.run("squeue", "-h", "-r", "-a", "-t", "all", "-o", "%i|%T|%r|%N", *options).stdout.splitlines()
        return {job: Task(*rest) for job, *rest in (line.split("|") for line in lines)}

    def submit(self, *options, script=None):
        """The id of a new job, an array or not; `script` is the text of a shell script."""
        result = self.run("sbatch", "--parsable", *options, input="#!/bin/sh\n" + script) if script is not None else self.run(
            "sbatch", "--parsable", *options)
        return result.stdout.strip().partition(";")[0]

    def wait_idle(self, timeout=PATIENCE):
        """Waits until no job is pending or runs; returns `queue()`. A job that can never run is waited for in vain."""
        done = {"COMPLETED", "FAILED", "CANCELLED", "TIMEOUT", "NODE_FAIL", "BOOT_FAIL", "DEADLINE", "OUT_OF_MEMORY", "PREEMPTED"}

        def finished():
            queue = self.queue()
            return (queue,) if all(task.state in done for task in queue.values()) else None
        return self.wait_for(finished, "all jobs were done", timeout=timeout)[0]


def guard(folder):
    """Waits until the process that started this one closes the pipe or ends, then ends what is left of its cluster."""
    sys.stdin.buffer.read()
    kill_all(SlurmCluster(folder).is_ours)


if __name__ == "__main__":
    guard(sys.argv[1])
