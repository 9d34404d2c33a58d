"""A Slurm cluster of one machine: munged, slurmctld and slurmd on the loopback interface, with all
their files in one folder. Wants root and Debian's packages munge, slurmctld, slurmd, slurm-client.
"""

import os
import shutil
import signal
import socket
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

DAEMONS = ("munged", "slurmctld", "slurmd")

SETTINGS = """\
ClusterName=atlas
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller_port}
SlurmdPort={node_port}
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
CryptoType=crypto/munge
# A job that is put back into the queue starts once its first credential has expired,
# after five seconds at the least.
AuthInfo=socket={folder}/munge.socket,cred_expire=5
# A job that its node does not know of counts as lost so long after its start, both times together.
MessageTimeout=5
BatchStartTimeout=1
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MailProg=/bin/true
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=batch_sched_delay=1,sched_interval=1
ReturnToService=2
# Two cores, even where the machine has one.
SlurmdParameters=config_overrides
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def missing() -> str | None:
    """Why no cluster can be started here; nothing where one can."""
    if os.geteuid() != 0:
        return "Slurm's daemons want root"
    absent = [name for name in (*DAEMONS, "sbatch") if shutil.which(name) is None]
    return f"not installed: {', '.join(absent)} (scripts/setup --slurm)" if absent else None


def free_ports(count: int) -> list[int]:
    """Ports of the loopback interface that nobody listens on."""
    sockets = [socket.socket() for _ in range(count)]
    for each in sockets:
        each.bind(("127.0.0.1", 0))
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    return ports


class SlurmCluster:
    """The daemons, from start to end."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        # munged looks whether everybody may reach its socket.
        folder.chmod(0o755)
        for name in ("state", "spool"):
            (folder / name).mkdir()
        controller_port, node_port = free_ports(2)
        settings = SETTINGS.format(
            host=socket.gethostname().split(".")[0],
            folder=folder,
            controller_port=controller_port,
            node_port=node_port,
        )
        (folder / "slurm.conf").write_text(settings)
        self.environment = {**os.environ, "SLURM_CONF": str(folder / "slurm.conf")}
        key = folder / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o400)
        self.daemons: dict[str, subprocess.Popen] = {}
        files = ("key-file=munge.key", "socket=munge.socket", "pid-file=munged.pid",
                 "log-file=munged.log", "seed-file=munged.seed")  # fmt: skip
        named = [f"--{option}={folder / name}" for option, name in (f.split("=") for f in files)]
        self.start("munged", "--foreground", "--force", *named)
        self.wait_for((folder / "munge.socket").exists)
        self.start("slurmctld", "-D", "-c")
        self.start("slurmd", "-D")
        self.wait_for(lambda: "idle" in self.said("sinfo", "--noheader", "--format=%T"))

    def start(self, name: str, *arguments: str) -> None:
        """Starts a daemon, which ends with this process; what it says goes to a file."""
        with open(self.folder / f"{name}.out", "ab") as out:
            self.daemons[name] = subprocess.Popen(
                ["setpriv", "--pdeathsig", "TERM", name, *arguments], env=self.environment, stdin=subprocess.DEVNULL,
                stdout=out, stderr=subprocess.STDOUT,
            )  # fmt: skip

    def said(self, *command: str) -> str:
        """What a command of Slurm prints, its complaints left out."""
        ended = subprocess.run(
            command, env=self.environment, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        return ended.stdout

    def idle(self) -> bool:
        """Whether no job is left. A squeue that gets no answer says nothing, and means nothing."""
        ended = subprocess.run(
            ["squeue", "--noheader"], env=self.environment, capture_output=True, text=True
        )
        return ended.returncode == 0 and not ended.stdout

    def wait_for(self, met: Callable[[], object], seconds: float = 30.0) -> None:
        """Waits until `met()`."""
        end = time.monotonic() + seconds
        while not met():
            assert time.monotonic() < end, self.logs()
            time.sleep(0.1)

    def logs(self) -> str:
        """What the daemons have written, to see why something does not come about."""
        files = [*self.folder.glob("*.out"), *self.folder.glob("*.log")]
        return "\n".join(f"== {f.name}\n{f.read_text(errors='replace')}" for f in sorted(files))

    def lose_node(self, processes: list[int]) -> None:
        """A node goes down and comes back: its daemon and these processes are killed, the daemon is
        started anew and does not know of their job."""
        for process in processes:
            os.kill(process, signal.SIGKILL)
        self.daemons["slurmd"].kill()
        self.daemons["slurmd"].wait()
        # MessageTimeout and BatchStartTimeout, and some.
        time.sleep(8)
        self.start("slurmd", "-D")

    def stop(self) -> None:
        """Ends jobs and daemons."""
        self.said("scancel", "--user=root")
        self.wait_for(self.idle)
        for name in reversed(DAEMONS):
            if name in self.daemons:
                self.daemons[name].terminate()
        for daemon in self.daemons.values():
            daemon.wait(timeout=30)
