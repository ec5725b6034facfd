"""The profile for Slurm, on a real slurmctld and slurmd that these tests start on this machine.

Needs Debian's packages slurm-wlm and munge and the rights of root; deselected unless ``-m slurm`` asks for it, and
then a machine without them fails.
"""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from projects import TARGETS, Project

pytestmark = [pytest.mark.slurm]

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "srun")
CONFIGURATION = Path("/etc/slurm/slurm.conf")
"""The executor takes variables that name another place out of its environment."""

SLURM_CONF = """
ClusterName=ptl
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
SlurmctldPort=36817
SlurmdPort=36818
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CryptoType=crypto/munge
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/filetxt
JobCompLoc={folder}/completed
MpiDefault=none
ReturnToService=2
SchedulerParameters=sched_interval=1,batch_sched_delay=0
MinJobAge=600
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
NodeName={host} NodeHostname={host} NodeAddr=127.0.0.1 CPUs=2 RealMemory={memory} State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def call(*arguments: str) -> str:
    return subprocess.run(arguments, check=True, capture_output=True, text=True, timeout=30).stdout


def wait_for(condition, seconds: float, what: str) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, f"waited {seconds} s for {what}"
        time.sleep(0.2)


@pytest.fixture(scope="module")
def cluster(tmp_path_factory) -> Iterator[Path]:
    """A cluster of one node, this machine."""
    search = os.environ["PATH"] + ":/usr/sbin:/sbin"
    missing = [name for name in PROGRAMS if shutil.which(name, path=search) is None]
    if missing:
        pytest.fail(f"no {', '.join(missing)}: the Slurm tests need Debian's slurm-wlm and munge")
    if os.geteuid() != 0:
        pytest.fail("the Slurm tests start slurmctld and slurmd, which takes the rights of root")
    folder = tmp_path_factory.mktemp("slurm")
    for parent in (folder, *folder.parents[:-1]):
        parent.chmod(parent.stat().st_mode | 0o011)  # munge wants to pass
    for name in ("state", "spool"):
        (folder / name).mkdir()
    key = folder / "munge.key"
    key.write_bytes(os.urandom(1024))
    key.chmod(0o400)
    kept = CONFIGURATION.read_bytes() if CONFIGURATION.exists() else None
    CONFIGURATION.parent.mkdir(exist_ok=True)
    host = socket.gethostname().partition(".")[0]
    CONFIGURATION.write_text(SLURM_CONF.format(folder=folder, host=host, memory=3000))
    daemons: list[subprocess.Popen] = []

    def daemon(*arguments: str) -> None:
        program = shutil.which(arguments[0], path=search)
        with (folder / f"{arguments[0]}.out").open("wb") as out:
            daemons.append(subprocess.Popen([program, *arguments[1:]], stdout=out, stderr=out))

    try:
        daemon("munged", "--foreground", "--force", f"--key-file={key}", f"--socket={folder}/munge.socket",
               f"--pid-file={folder}/munged.pid", f"--log-file={folder}/munged.log",
               f"--seed-file={folder}/munged.seed")  # fmt: skip
        wait_for((folder / "munge.socket").exists, 20, f"munged; see {folder}/munged.out")
        daemon("slurmctld", "-D", "-c")
        daemon("slurmd", "-D")
        wait_for(lambda: node_state() == "idle", 60, f"an idle node; see {folder}")
        yield folder
    finally:
        subprocess.run(["scancel", "--user=root"], capture_output=True)
        for process in reversed(daemons):
            process.send_signal(signal.SIGTERM)
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
        if kept is None:
            CONFIGURATION.unlink()
        else:
            CONFIGURATION.write_bytes(kept)


OPTIONS = (
    "--workflow-profile", "profiles/slurm", "--cores", "2", "--slurm-status-command", "squeue", "--slurm-no-account",
    "--slurm-init-seconds-before-status-checks", "2", "--seconds-between-status-checks", "2", "--latency-wait", "10",
)  # fmt: skip
"""Options in addition to the profile: the cluster has two cores and no accounting, and quick answers save time."""


@pytest.fixture
def start() -> Iterator[Callable[..., subprocess.Popen]]:
    """Starts snakemake on the cluster, and ends it if a failed test leaves it behind."""
    runs: list[subprocess.Popen] = []

    def begin(project: Project, *arguments: str) -> subprocess.Popen:
        runs.append(_start(project, *arguments))
        return runs[-1]

    yield begin
    for run in runs:
        if run.poll() is None:
            run.kill()
            run.wait()


def _start(project: Project, *arguments: str) -> subprocess.Popen:
    environment = {name: value for name, value in project.environment.items() if not name.startswith("SLURM")}
    environment["PATH"] = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    with (project.folder / "snakemake.out").open("ab") as out:
        return subprocess.Popen(
            [sys.executable, "-m", "snakemake", *arguments, *OPTIONS],
            cwd=project.folder, env=environment, stdout=out, stderr=out,
        )  # fmt: skip


def finish(project: Project, run: subprocess.Popen, seconds: float = 200) -> None:
    assert run.wait(seconds) == 0, (project.folder / "snakemake.out").read_text()[-4000:]


def completed(cluster: Path) -> list[str]:
    """A line for each Slurm job that has ended."""
    log = cluster / "completed"
    return log.read_text().splitlines() if log.exists() else []


@pytest.fixture(scope="module")
def local(tmp_path_factory) -> Project:
    project = Project(tmp_path_factory.mktemp("local"))
    project.make(*TARGETS)
    return project


def test_same_bytes_as_locally_and_many_seeds_in_one_job(cluster, local, start, tmp_path, record_property):
    project = Project(tmp_path / "project")
    before = len(completed(cluster))
    finish(project, start(project, *TARGETS))
    assert project.files("results", "reports") == local.files("results", "reports")
    jobs = [line for line in completed(cluster)[before:] if "JobState=COMPLETED" in line]
    # six learning jobs, two lives and two batches went into one Slurm job each
    text = (project.folder / "snakemake.out").read_text()
    assert 4 <= len(jobs) <= 7, (len(jobs), text[-3000:])
    record_property("runs on Slurm, same bytes as here", 1)


def test_node_lost_in_the_middle_costs_only_its_jobs(cluster, local, start, tmp_path, record_property):
    """The node goes down with jobs on it; results that were there stay, and the run ends as it should."""
    project = Project(tmp_path / "project")
    host = socket.gethostname().partition(".")[0]
    target = "reports/tiny/tables/per_seed.csv"
    run = start(project, target, "--group-components", "learning=1")
    learned = project.folder / "results/tiny/learning"
    wait_for(lambda: len(list(learned.rglob("seed_*.h5"))) >= 2, 120, "two results")
    call("scontrol", "update", f"NodeName={host}", "State=DOWN", "Reason=test")
    times = {path: path.stat().st_mtime_ns for path in learned.rglob("seed_*.h5")}
    time.sleep(2)
    # A node that still answers comes back by itself (ReturnToService=2), and then refuses to be resumed.
    subprocess.run(["scontrol", "update", f"NodeName={host}", "State=RESUME"], capture_output=True)
    wait_for(lambda: node_state() in {"idle", "mixed", "allocated"}, 60, "the node to come back")
    if run.wait(200) != 0:  # jobs of the node were lost: the same command goes on with them
        finish(project, start(project, target))
    whole = local.files("results", "reports")
    found = project.files("results", "reports")
    assert target in found and all(content == whole[name] for name, content in found.items())
    made_again = [path for path, made in times.items() if path.stat().st_mtime_ns != made]
    assert len(made_again) <= 2  # the jobs that were on the node's two cores
    record_property("runs on Slurm that lost their node, same bytes in the end", 1)


def node_state() -> str:
    return subprocess.run(["sinfo", "-h", "-o", "%T"], capture_output=True, text=True).stdout.strip()
