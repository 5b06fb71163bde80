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
from types import SimpleNamespace

import numpy as np

try:
    from distributed import Client, LocalCluster
except ImportError:
    print("Dask not found: skipped")
    sys.exit(77)

from planar_chain import Scene
from planar_chain.sweeps import results_there, run_chunk
from sweep_tool import LIMIT, MASS, SCENE, VARIED, SweepTool


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

    def test_results_that_die_with_their_workers_are_computed_again(self):
        scene, times, values = Scene.from_file(SCENE), np.array([0.0, 1.0]), np.linspace(0.5, 2, 12)[:, None]
        chunks = {start: (scene.to_dict(), [MASS], values[start:start + 1], times) for start in range(12)}
        sweep = SimpleNamespace(missing=lambda: list(chunks), arguments=chunks.get)
        with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
            results = results_there(sweep, cluster.scheduler_address)
            got = dict([next(results)])
            while sum(map(len, client.has_what().values())) < 11:
                time.sleep(0.05)
            for worker in client.run(os.getpid).values():  # both: else the other one has computed them before the client asks
                os.kill(worker, signal.SIGKILL)
            while client.has_what():
                time.sleep(0.01)
            got.update(results)
        self.assertEqual(sorted(got), list(chunks))
        for start, (states, *_) in got.items():
            np.testing.assert_array_equal(states, run_chunk(*chunks[start])[0])


if __name__ == "__main__":
    unittest.main()
