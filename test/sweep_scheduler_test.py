#!/usr/bin/python3
"""sweep on a Dask scheduler: one that is not there, has no workers, is killed; two workers of which one is killed.

    sweep_scheduler_test.py BIN [unittest options]        BIN: the folder that holds the tools; PYTHONPATH finds planar_chain
"""
import os
import signal
import subprocess
import sys
import time
import unittest

try:
    from distributed import Client, LocalCluster
except ImportError:
    print("Dask not found: skipped")
    sys.exit(77)

from sweep_tool import LIMIT, MASS, VARIED, SweepTool


class Scheduler(SweepTool):
    def test_a_killed_scheduler_loses_nothing(self):
        arguments = (*VARIED, "--runs", "20000", "--duration", "30", "--chunk", "20")
        script = ("import sys\nfrom distributed import LocalCluster\nif __name__ == '__main__':\n"
                  " with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:\n"
                  "  print(cluster.scheduler_address, flush=True)\n  sys.stdin.read()\n")
        with open(self.path("cluster.py"), "w", encoding="utf-8") as file:
            file.write(script)
        with subprocess.Popen([sys.executable, self.path("cluster.py")], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL, universal_newlines=True, start_new_session=True) as cluster:
            address = cluster.stdout.readline().strip()
            process = subprocess.Popen(self.command(*arguments, "--scheduler", address), stderr=subprocess.PIPE, universal_newlines=True)
            os.makedirs(self.path("runs.csv.parts"), exist_ok=True)
            self.wait_for_chunks(3, process)
            os.killpg(cluster.pid, signal.SIGKILL)
            said = process.communicate(timeout=LIMIT)[1]
        self.assertEqual(process.returncode, 1, said)
        self.assertRegex(said, rf"^sweep: the scheduler {address} does not answer "
                               r"\(after \d+ of 20000 runs; the same command goes on from there\)$")
        self.assertGreaterEqual(int(said.split("after ")[1].split()[0]), 60)
        self.assertEqual([name for name in os.listdir(self.path("runs.csv.parts")) if name.endswith(".partial")], [])
        self.sweep(*arguments)
        self.sweep(*arguments, output=("whole.csv",))
        self.assertEqual(self.text("runs.csv"), self.text("whole.csv"))

    def test_one_that_is_not_there_is_said_at_once_and_ends_with_ctrl_c(self):
        arguments = ("--vary", MASS + "=1:2:4", "--duration", "1", "--scheduler", "tcp://127.0.0.1:1")
        for pauses in ((0,), (0.02, 0.05, 0.1)):  # after each Ctrl-C
            with subprocess.Popen(self.command(*arguments), stderr=subprocess.PIPE, universal_newlines=True) as process:
                self.assertEqual(process.stderr.readline(), "sweep: the scheduler tcp://127.0.0.1:1 does not answer; waiting 20 s for it\n")
                for pause in pauses:
                    process.send_signal(signal.SIGINT)
                    time.sleep(pause)
                said = process.communicate(timeout=10)[1]
            self.assertIn(process.returncode, (130, -signal.SIGINT)[:len(pauses)])
            self.assertEqual(said, "sweep: interrupted (after 0 of 4 runs; the same command goes on from there)\n")

    def test_a_scheduler_without_workers_says_so(self):
        with LocalCluster(n_workers=0, dashboard_address=None) as cluster:
            address, begin = cluster.scheduler_address, time.monotonic()
            said = self.sweep("--vary", MASS + "=1:2:4", "--duration", "1", "--scheduler", address, status=1)
        self.assertRegex(said, rf"^sweep: the scheduler {address} has no workers; waiting 20 s for one\n"
                               rf"sweep: the scheduler {address} has had no workers for 20 s; start one with: dask-worker {address} ")
        self.assertGreaterEqual(time.monotonic() - begin, 20)

    def test_a_killed_worker_loses_nothing(self):
        arguments = (*VARIED, "--runs", "600", "--duration", "100", "--chunk", "20")
        self.sweep(*arguments, output=("whole.csv",))
        with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
            workers = client.run(os.getpid)
            self.assertEqual(len(workers), 2)
            process = subprocess.Popen(self.command(*arguments, "--scheduler", cluster.scheduler_address))
            os.makedirs(self.path("runs.csv.parts"), exist_ok=True)
            self.wait_for_chunks(3, process)
            os.kill(next(iter(workers.values())), signal.SIGKILL)
            self.assertLess(len(os.listdir(self.path("runs.csv.parts"))), 25)
            self.assertEqual(process.wait(LIMIT), 0)
        self.assertEqual(self.text("runs.csv"), self.text("whole.csv"))


if __name__ == "__main__":
    unittest.main()
