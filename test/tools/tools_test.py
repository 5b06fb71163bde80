#!/usr/bin/python3
"""simulate and equations as their users meet them: exit statuses, files, messages.

    tools_test.py BIN [unittest options]        BIN: the folder that holds both
"""
import csv
import faulthandler
import json
import math
import os
import pty
import re
import select
import signal
import subprocess
import sys
import time
import unittest

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../support"))
from in_folder import InFolder  # noqa: E402

BIN = ""
ROD = "{mass: 1, inertia: 1e-1, com: [0.5, 0], pin: [1, 0]}"
SCENE = f"chain: [upper, lower]\nlinks: {{upper: {ROD}, lower: {ROD}}}\n"

ROBOT = """<robot name="r">
  <link name="ground"/>
  <link name="rod"><inertial><origin xyz="0 0 -0.5"/><mass value="2"/>
    <inertia ixx="0.2" ixy="0" ixz="0" iyy="0.25" iyz="0" izz="0.1"/></inertial></link>
  <joint name="pin" type="continuous"><parent link="ground"/><child link="rod"/><axis xyz="0 1 0"/></joint>
</robot>
"""


def has_ros():
    return os.path.exists(os.path.join(BIN, "..", "libplanar_chain_bags.so"))


class Tools(InFolder):
    def run_tool(self, tool, *arguments, scene=SCENE):
        with open(self.path("scene.yaml"), "w") as file:
            file.write(scene)
        command = [os.path.join(BIN, tool), self.path("scene.yaml"), *arguments]
        return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              universal_newlines=True, timeout=60)

    def simulate(self, *arguments, scene=SCENE):
        return self.run_tool("simulate", "--csv", self.path("out.csv"), *arguments, scene=scene)

    def rows(self):
        with open(self.path("out.csv"), newline="") as file:
            header, *rows = csv.reader(file)
        return header, [[float(entry) for entry in row] for row in rows]

    def assert_refused(self, result, *words):
        """Status 2, the words said, nothing written."""
        self.assertEqual(result.returncode, 2, result.stderr)
        for word in words:
            self.assertIn(word, result.stderr)
        self.assertEqual(result.stdout, "")
        self.assertFalse(os.path.exists(self.path("out.csv")))

    # ---- Arguments ---------------------------------------------------------------------------------

    def test_a_misspelt_option_or_scene_is_told_the_nearest(self):
        for given in ("--durtion", "-duration"):
            self.assert_refused(self.simulate(given, "1"), f"{given}: expected an option of simulate (did you mean --duration?), got none")
        self.assert_refused(self.simulate("more", "--duration", "1"), "SCENE: expected one, got more arguments without --\n")
        self.assert_refused(self.run_tool("equations", "--q", "0.1,", "0.2"),
                            "SCENE: expected one, got more arguments without -- (no blank behind a comma: 0.1,0.2)\n")
        for given in (("1e9",), ("0",), ("1", "x"), ("1", "1", "1"), ("99999999999999999999",)):
            run = subprocess.run([os.path.join(BIN, "batches"), *given], stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True)
            self.assert_refused(run, "batches [RUNS [PAIRS]]: expected whole numbers from 1 to 1000000\n")
        run = subprocess.run([os.path.join(BIN, "simulate"), "pendulm", "--check"], stderr=subprocess.PIPE, universal_newlines=True)
        self.assertIn("whip (did you mean pendulum?), got neither", run.stderr)

    def test_the_node_says_its_usage_without_a_master(self):
        if not has_ros():
            self.skipTest("built without ROS")
        for given, status in (("--help", 0), ("scene.yaml", 2)):
            run = subprocess.run([os.path.join(BIN, "planar_chain_node"), given], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                 universal_newlines=True, timeout=60)
            self.assertEqual((run.returncode, run.stdout[:39]), (status, "planar_chain_node [--wait-for-recorder]"))

    # ---- A budget of steps -------------------------------------------------------------------------

    def test_a_run_without_end_stops_with_a_reason(self):
        wild = SCENE + "loads: {blast: {joint: lower_joint, torque: 1e12}}\n"
        result = self.simulate("--duration", "0.005", "--rate", "1e6", "--most-steps", "20000", scene=wild)
        self.assertEqual((result.returncode, result.stdout), (1, ""), result.stderr)
        self.assertRegex(result.stderr, r"simulate: stopped at t = \S+ s of 0.005 s after 200\d\d steps: the rate of "
                         r"lower_joint is \S+ rad/s, the torque in lower_joint 1e\+12 N m; expected at most 20000 steps "
                         r"\(--most-steps\)\nThe last state:\n")
        _, rows = self.rows()
        self.assertGreater(len(rows), 10)
        self.assertTrue(all(math.isfinite(entry) for row in rows for entry in row))
        self.assertRegex(self.simulate("--duration", "10", "--rate", "0.1", "--most-steps", "20").stderr, " after 3[2-9] steps")
        self.assertIn("(--most-steps); each row takes a step (--rate)\n", self.simulate("--duration", "1", "--rate", "1e4", "--most-steps", "2000").stderr)
        fine = self.simulate("--duration", "10", "--tolerance", "1e-12", "--most-steps", "20").stderr
        self.assertIn("; the tolerance is 1e-12, and below 1e-10 rounding may exceed it; expected at most 20 steps", fine)
        self.assertEqual(self.simulate("--duration", "1", "--most-steps", "10000").returncode, 0)
        limited = SCENE.replace(ROD, ROD[:-1] + ", joint: {KEYS}}", 1)
        for scene, key in ((SCENE + "loads: {hum: {joint: lower_joint, torque: 1, frequency: 1e6}}\n", "frequency of load hum (1e+06 Hz)"),
                           (SCENE + "base: {x: {amplitude: 1e-6, frequency: 1e6}}\n", "frequency of base/x (1e+06 Hz)"),
                           (limited.replace("KEYS", "drive: {amplitude: 1e-9, frequency: 1e7}"), "frequency of drive of upper_joint (1e+07 Hz)"),
                           (limited.replace("KEYS", "drag: 1e100"), "drag of upper_joint (1e+100 N m s²/rad²)"),
                           (limited.replace("KEYS", "lower: -0.5, stop_damping: 1e100"), "stop_damping of upper_joint (1e+100 N m s/rad)")):
            said = self.simulate("--duration", "1", "--most-steps", "2000", scene=scene)
            self.assertEqual(said.returncode, 1, scene)
            self.assertIn(f"; the fastest key is {key}; ", said.stderr)
        os.remove(self.path("out.csv"))
        self.assert_refused(self.simulate("--duration", "1", "--most-steps", "0"), "--most-steps: expected a number > 0")

    # ---- A robot's URDF ----------------------------------------------------------------------------

    def run_robot(self, tool, *arguments, robot=ROBOT, how=("--urdf",)):
        with open(self.path("robot.urdf"), "w") as file:
            file.write(robot)
        command = [os.path.join(BIN, tool), *how, self.path("robot.urdf"), *arguments]
        return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              universal_newlines=True, timeout=60)

    def test_a_robot_is_a_scene(self):
        # A rod of 2 kg, 0.5 m from its level axis, in the wind of gravity: M = I + m r², f = -m g r sin q.
        result = self.run_robot("equations", "--json", "--q", "1.5707963267948966")
        self.assertEqual(result.returncode, 0, result.stderr)
        told = json.loads(result.stdout)
        self.assertAlmostEqual(told["M"][0][0], 0.25 + 2 * 0.25, delta=1e-14)
        self.assertAlmostEqual(told["f"][0], -2 * 9.81 * 0.5, delta=1e-13)
        for how in (("--urdf",), ()):
            result = self.run_robot("simulate", "--duration", "1", "--csv", self.path("out.csv"), how=how)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(self.rows()[0], ["t", "q_pin", "qd_pin", "energy"])
            os.remove(self.path("out.csv"))

    def test_a_scene_says_the_rest(self):
        beside = "links: {rod: {initial: {angle: 0.5}}}\ngravity: [0, 0]\n"
        result = self.simulate("--duration", "1", "--urdf", self.path("robot.urdf"), scene=beside)
        self.assert_refused(result, self.path("robot.urdf") + ": expected a file that can be read, got nothing: No such file or directory\n")
        with open(self.path("robot.urdf"), "w") as file:
            file.write(ROBOT)
        result = self.simulate("--duration", "1", "--urdf", self.path("robot.urdf"), scene=beside)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual({row[1] for row in self.rows()[1]}, {0.5})
        os.remove(self.path("out.csv"))
        self.assert_refused(self.simulate("--duration", "1", "--urdf", self.path("robot.urdf")),
                            "chain: expected no chain beside robot_description")
        for scene in ("robot_description: x", ROBOT):
            self.assert_refused(self.simulate("--duration", "1", "--urdf", self.path("robot.urdf"), scene=scene), "nothing beside --urdf")

    def test_a_robot_is_not_written_over(self):
        for how in (("--urdf",), ()):
            self.assert_refused(self.run_robot("simulate", "--duration", "1", "--csv", self.path("robot.urdf"), how=how),
                                "--csv: expected a file that is not another of the run's")

    def test_a_robot_that_is_no_chain_is_refused_with_all_other_faults(self):
        self.assert_refused(
            self.run_robot("simulate", "--duration", "-1", robot=ROBOT.replace("continuous", "screw")),
            "--duration", 'robot_description/joint[pin]/type: expected ', 'got "screw"')

    def test_a_scene_without_a_name(self):
        result = subprocess.run([os.path.join(BIN, "simulate"), ""], stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True, timeout=60)
        self.assert_refused(result, '"": expected a file, or one of the scenes that ship')

    def test_memory_that_ends_is_said(self):
        program = os.path.join(BIN, "equations")
        if "libasan" in subprocess.run(["ldd", program], stdout=subprocess.PIPE, universal_newlines=True).stdout:
            self.skipTest("the sanitizer ends the program first")
        with open(self.path("long.yaml"), "w") as file:
            file.write(f"chain: [rod]\nlinks: {{rod: {ROD[:-1]}, repeat: 900}}}}\n")
        result = subprocess.run(["bash", "-c", 'ulimit -v 60000; exec "$0" "$@"', program, self.path("long.yaml")],
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True, timeout=60)
        self.assertEqual((result.returncode, result.stderr), (1, "equations: there is not enough memory\n"))

    def test_neither_scene_nor_robot(self):
        for tool, *arguments in (("simulate", "--duration", "1"), ("equations",)):
            result = subprocess.run([os.path.join(BIN, tool), *arguments], stdout=subprocess.PIPE,
                                    stderr=subprocess.PIPE, universal_newlines=True, timeout=60)
            self.assert_refused(result, "SCENE: expected a scene file, or --urdf")

    # ---- simulate: rows --------------------------------------------------------------------------

    def test_columns(self):
        self.assertEqual(self.simulate("--duration", "1").returncode, 0)
        header, rows = self.rows()
        self.assertEqual(header, ["t", "q_upper_joint", "q_lower_joint", "qd_upper_joint",
                                  "qd_lower_joint", "energy"])
        self.assertEqual(len(rows), 101)
        self.assertEqual(rows[0], [0] * 6)

    def times(self, duration, rate):
        result = self.simulate("--duration", duration, "--rate", rate)
        self.assertEqual(result.returncode, 0, result.stderr)
        return [row[0] for row in self.rows()[1]]

    def test_times_come_from_the_index(self):
        self.assertEqual(self.times("1", "10"), [k / 10 for k in range(11)])

    def test_the_duration_has_a_row_of_its_own(self):
        self.assertEqual(self.times("0.35", "10"), [0, 0.1, 0.2, 0.3, 0.35])

    def test_no_last_row_is_doubled_by_rounding(self):
        self.assertEqual(self.times("0.3", "10"), [0, 0.1, 0.2, 0.3])
        self.assertEqual(len(self.times("0.7", "30")), 22)
        self.assertEqual(len(self.times("1e-1", "1e3")), 101)

    def test_a_rate_below_one_row_gives_both_ends(self):
        self.assertEqual(self.times("0.5", "1"), [0, 0.5])

    def test_too_many_rows_are_refused(self):
        self.assert_refused(self.simulate("--duration", "1e9", "--rate", "1e9"), "100000000 rows")

    # ---- simulate: arguments ---------------------------------------------------------------------

    def test_method_and_step_override_the_scene(self):
        result = self.simulate("--duration", "1", "--method", "rk4", "--step", "1e-2",
                               scene=SCENE + "integrator: {method: dopri5, step: 1}\n")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("rk4: 100 steps", result.stdout)
        self.assertIn(" evaluations (closed form for two)", result.stdout)

    def test_a_tighter_tolerance_conserves_energy_better(self):
        def drift(tolerance):
            self.simulate("--duration", "3", "--method", "dopri5", "--tolerance", tolerance)
            energies = [row[-1] for row in self.rows()[1]]
            return max(energies) - min(energies)
        self.assertLess(drift("1e-11"), 1e-2 * drift("1e-5"))

    def test_overrides_are_judged_as_the_scene_is(self):
        result = self.simulate("--duration", "1", "--method", "magic", "--tolerance", "0", "--step", "x")
        self.assert_refused(result, "integrator/method: expected one of auto, rk4",
                            "integrator/tolerance", 'integrator/step: expected a number >= 1e-12 s, got "x"')

    def test_the_duration_is_required_positive_and_finite(self):
        self.assert_refused(self.simulate(), "--duration: expected a finite number > 0 s, or --commands")
        for duration in ("-1", "0", "inf", "nan", "soon", ""):
            self.assert_refused(self.simulate("--duration", duration),
                                f'--duration: expected a finite number > 0 s, got "{duration}"')

    def test_units_are_not_written(self):
        self.assert_refused(self.simulate("--duration", "10s"), 'got "10s" (write the number alone')
        self.assert_refused(self.simulate("--duration", "0,5"), 'got "0,5" (a decimal point, not a comma?)')

    def test_unknown_options_are_refused(self):
        self.assert_refused(self.simulate("--duration", "1", "--frobnicate"), "--frobnicate")

    def test_all_faults_of_arguments_and_scene_come_at_once(self):
        result = self.simulate("--duration", "-1", "--rate", "0",
                               scene=SCENE.replace("mass: 1", "mass: -1"))
        self.assert_refused(result, "--duration", "--rate", "links/upper/mass", "links/lower/mass")

    def test_help(self):
        result = self.run_tool("simulate", "--help")
        self.assertEqual(result.returncode, 0)
        self.assertIn("--duration", result.stdout)

    # ---- simulate: files -------------------------------------------------------------------------

    def test_scenes_that_cannot_be_read(self):
        for path in (self.path("none.yaml"), self.folder, "/dev/zero"):
            result = subprocess.run([os.path.join(BIN, "simulate"), path, "--duration", "1"],
                                    stderr=subprocess.PIPE, universal_newlines=True, timeout=60)
            self.assertEqual(result.returncode, 2)
            self.assertIn(path, result.stderr)

    def test_broken_yaml_names_the_line(self):
        self.assert_refused(self.simulate("--duration", "1", scene="chain: [l\n  - x: {"), "line 2")
        self.assert_refused(self.simulate("--duration", "1", scene="chain: [l]\nlinks:\n\tl: {}\n"),
                            self.path("scene.yaml") + ":3: scene: expected YAML, got line 3, column 3: a tab")

    def test_faults_name_file_and_line(self):
        scene = "chain: [l, m]\nlinks:\n  l:\n    mass: 1.0 kg\n    com: [0, 0.5 m]\n    pin: [0, 0]\n  m: {}\n"
        result = self.simulate("--duration", "-1", "--method", "magic", scene=scene)
        self.assert_refused(result)
        file, note = self.path("scene.yaml"), " (write the number alone: units are not written)"
        self.assertEqual(sorted(line.split("expected")[0] for line in result.stderr.splitlines()), sorted([
            "--duration: ", "integrator/method: ", f"{file}:4: links/l/mass: ", f"{file}:3: links/l/inertia: ",
            f"{file}:5: links/l/com: ", *(f"{file}:7: links/m/{key}: " for key in ("mass", "inertia", "com", "pin"))]))
        self.assertIn('got "1.0 kg"' + note, result.stderr)
        self.assertIn('got [0, "0.5 m"]' + note, result.stderr)

    def test_faults_of_a_urdf_name_its_file_and_line(self):
        for how in (("--urdf",), ()):
            result = self.run_robot("simulate", "--check", robot=ROBOT.replace('value="2"', 'value="2 kg"'), how=how)
            self.assert_refused(result)
            self.assertEqual(result.stderr, self.path("robot.urdf") + ":3: robot_description/link[rod]/inertial/mass/value: "
                             'expected a finite number >= 0 kg, got "2 kg" (write the number alone: units are not written)\n')

    def run_scene(self, *arguments):
        return subprocess.run([os.path.join(BIN, "simulate"), *arguments], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, universal_newlines=True, timeout=60, cwd=self.folder)

    def test_scenes_that_ship_are_found_by_name(self):
        result = self.run_scene("rope", "--check")
        self.assertEqual((result.returncode, result.stdout), (0, "no faults: 100 links, 0 loads, method auto\n"))
        os.mkdir(self.path("rope"))  # is no scene
        self.assertEqual(self.run_scene("rope", "--check").stdout, result.stdout)
        os.rmdir(self.path("rope"))
        with open(self.path("rope"), "w") as file:
            file.write(SCENE)
        self.assertIn("2 links", self.run_scene("rope", "--check").stdout)  # a file of that name comes first
        self.assert_refused(self.run_scene("roqe", "--check"),
                            "roqe: expected a file, or one of the scenes that ship: a02, acrobot, ", "rope", "got neither")

    def test_files_of_other_programs_are_named(self):
        for start, words in (("#ROSBAG V2.0\n", ":1: scene: expected YAML or a URDF, got a bag"),
                             ("<?xml version='1.0'?>", ": robot_description: expected one element robot, got nothing")):
            self.assert_refused(self.simulate("--duration", "1", scene=start), self.path("scene.yaml") + words)

    def test_an_unwritable_csv_ends_it_before_the_run(self):
        result = self.run_tool("simulate", "--duration", "1e6", "--csv", self.path("no/such/out.csv"))
        self.assert_refused(result, "--csv", "No such file")

    def test_the_scene_is_not_written_over(self):
        result = self.run_tool("simulate", "--duration", "1", "--csv", self.path("scene.yaml"))
        self.assert_refused(result, "--csv")
        with open(self.path("scene.yaml")) as file:
            self.assertEqual(file.read(), SCENE)

    def test_one_file_is_not_written_twice(self):
        if not has_ros():
            self.skipTest("without ROS there is one output")
        os.symlink(self.folder, self.path("folder"))
        os.symlink("x", self.path("link"))  # leads to a file that does not exist yet
        os.mkdir(self.path("sub"))
        self.run_tool("equations")  # writes the scene
        os.link(self.path("scene.yaml"), self.path("twin.yaml"))
        names = ("x", "./x", self.path("x"), "folder/x", "sub/../x", "link")
        for one, other in ((one, other) for one in names for other in names):
            for options in (("--csv", one, "--bag", other), ("--bag", one, "--write-urdf", other)):
                self.assert_refused(self.run_scene("scene.yaml", "--duration", "1", *options),
                                    f'{options[2]}: expected a file that is not another of the run\'s, got "{other}"')
        self.assert_refused(self.run_scene("scene.yaml", "--duration", "1", "--csv", "twin.yaml"), "--csv: expected a file that is not")
        self.assert_refused(self.run_scene("scene.yaml", "--duration", "1", "--commands", "x", "--bag", "link"), "--bag: expected a file that is not")
        self.assertEqual(sorted(os.listdir(self.folder)), ["folder", "link", "scene.yaml", "sub", "twin.yaml"])
        self.assertEqual(self.run_scene("scene.yaml", "--duration", "1", "--csv", "/dev/null", "--write-urdf", "/dev/null").returncode, 0)

    def test_a_limit_of_file_size_ends_the_run_in_words(self):
        self.run_tool("equations")  # writes the scene
        for option, out in (("--csv", "out.csv"), ("--bag", "out.bag"))[:2 if has_ros() else 1]:
            run = subprocess.run(["bash", "-c", 'ulimit -f 8; exec "$0" "$@"', BIN + "/simulate", "scene.yaml", "--duration", "100", option, out],
                                 stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True, timeout=60, cwd=self.folder)
            self.assertEqual((run.returncode, run.stderr), (1, f"simulate: cannot write {out}: File too large\n"))

    @unittest.skipUnless(os.path.exists("/dev/full"), "no /dev/full")
    def test_a_full_disk_fails_the_run(self):
        result = self.run_tool("simulate", "--duration", "0.1", "--csv", "/dev/full")
        self.assertEqual(result.returncode, 1)
        self.assertIn("No space left", result.stderr)

    @unittest.skipUnless(os.path.exists("/dev/full"), "no /dev/full")
    def test_output_that_cannot_be_written_fails_the_run(self):
        self.run_tool("equations")  # writes the scene
        scene = self.path("scene.yaml")
        for tool, *arguments in (("equations", scene), ("equations", scene, "--json"), ("equations", scene, "--chain"),
                                 ("equations", "--help"), ("simulate", scene, "--duration", "0.1"),
                                 ("simulate", scene, "--duration", "0.1", "--csv", "-"), ("simulate", scene, "--check"), ("simulate", "--help")):
            with open("/dev/full", "w") as full:
                result = subprocess.run([os.path.join(BIN, tool), *arguments], stdout=full, stderr=subprocess.PIPE,
                                        universal_newlines=True, timeout=60)
            self.assertEqual((result.returncode, result.stderr),
                             (1, f"{tool}: cannot write standard output: No space left on device\n"), arguments)

    def test_a_pipe_is_an_output_like_others(self):
        self.run_tool("equations")  # writes the scene
        os.mkfifo(self.path("pipe"))
        command = [os.path.join(BIN, "simulate"), self.path("scene.yaml"), "--duration", "0.1", "--csv"]
        subprocess.run([*command, self.path("out.csv")], stdout=subprocess.PIPE, check=True, timeout=60)
        # A check that opened the pipe would wait for its reader, and end it.
        bad = subprocess.run([*command, self.path("pipe"), "--rate", "0"], stderr=subprocess.PIPE, universal_newlines=True, timeout=60)
        self.assertEqual((bad.returncode, bad.stderr.count("\n")), (2, 1), bad.stderr)
        with subprocess.Popen(["cat", self.path("pipe")], stdout=subprocess.PIPE) as reader:
            try:
                subprocess.run([*command, self.path("pipe")], stdout=subprocess.PIPE, check=True, timeout=60)
                with open(self.path("out.csv"), "rb") as file:
                    self.assertEqual(reader.stdout.read(), file.read())
            finally:
                reader.kill()

    def test_a_dash_is_standard_output(self):
        command = "scene.yaml", "--duration", "0.1"
        summary = self.run_tool("simulate", *command[1:], "--csv", self.path("out.csv")).stdout
        rows = self.run_scene(*command, "--csv", "-")
        with open(self.path("out.csv")) as file:
            self.assertEqual((rows.returncode, rows.stdout, rows.stderr), (0, file.read(), summary))
        os.remove(self.path("out.csv"))
        for option in ("--bag", "--write-urdf"):
            self.assert_refused(self.run_scene(*command, option, "-"), f"{option}: expected a file, as only --csv goes to standard output, got -\n")
        self.assertEqual(os.listdir(self.folder), ["scene.yaml"])

    # ---- simulate: interrupted ---------------------------------------------------------------------

    def interrupted(self, *arguments, after, by=signal.SIGINT):
        """A run that gets a signal once after() is true."""
        with open(self.path("scene.yaml"), "w") as file:
            file.write(SCENE)
        command = [os.path.join(BIN, "simulate"), self.path("scene.yaml"), *arguments]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True) as run:
            deadline = time.monotonic() + 60
            while not after() and time.monotonic() < deadline:
                time.sleep(0.01)
            run.send_signal(by)
            try:
                return run.communicate(timeout=60) + (run.returncode,)
            finally:
                run.kill()

    def test_an_interrupted_run_ends_with_a_whole_row(self):
        def has_rows():
            return os.path.exists(self.path("out.csv")) and os.path.getsize(self.path("out.csv")) > 10 ** 5

        for by in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            out, error, status = self.interrupted("--duration", "1e6", "--csv", self.path("out.csv"), after=has_rows,
                                                  by=by)
            self.assertEqual((out, status), ("", 128 + by))
            header, rows = self.rows()
            self.assertEqual({len(row) for row in rows}, {len(header)})
            self.assertEqual([row[0] for row in rows], [k / 100 for k in range(len(rows))])
            said = re.fullmatch("simulate: interrupted; the last row is at t = (.*) s, of 1e\\+06 s\n", error).group(1)
            self.assertEqual(float(said), rows[-1][0])
            with open(self.path("out.csv")) as file:
                self.assertTrue(file.read().endswith("\n"))
            os.remove(self.path("out.csv"))

    def test_progress_and_interruption_within_a_row(self):
        master, terminal = pty.openpty()
        run = subprocess.Popen([os.path.join(BIN, "simulate"), "/dev/stdin", "--duration", "1e7", "--rate", "1e-7"],
                               stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=terminal)
        os.close(terminal)
        run.stdin.write(SCENE.encode())
        run.stdin.close()
        self.addCleanup(os.close, master)
        self.addCleanup(run.kill)
        seen = b""
        while seen.count(b" of 1e+07 s") < 3:
            self.assertTrue(select.select([master], [], [], 60)[0], seen)
            seen += os.read(master, 4096)
        run.send_signal(signal.SIGINT)
        self.assertEqual(run.wait(60), 130)
        times = [float(part.split(b"] ")[1]) for part in seen.split(b" of 1e+07 s")[:3]]
        self.assertLess(times[0], times[1])
        self.assertLess(times[1], times[2])

    def test_a_failed_run_keeps_its_rows(self):
        blow_up = SCENE + "loads: {p: {joint: lower_joint, torque: 1e300, start: 0.35}}\n"
        result = self.simulate("--duration", "1", "--rate", "10", scene=blow_up)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("failed at t = ", result.stderr)
        self.assertIn("last finite state", result.stderr)
        times = [row[0] for row in self.rows()[1]]
        self.assertEqual(times[:4], [0, 0.1, 0.2, 0.3])
        self.assertTrue(all(math.isfinite(x) for row in self.rows()[1] for x in row))

    def test_a_build_without_ros_has_no_bags(self):
        if has_ros():
            self.skipTest("this one has ROS: see bag_test.py")
        for option in ("--bag", "--commands"):
            result = self.run_tool("simulate", "--duration", "1", option, self.path("out.bag"))
            self.assert_refused(result, option, "expected a build with ROS")
            self.assertFalse(os.path.exists(self.path("out.bag")))

    # ---- simulate: what is shown -----------------------------------------------------------------

    def test_check_only_reads_the_scene(self):
        self.assert_refused(self.run_tool("simulate", "--check", "--csv", "x.csv", "--duration", "2"),
                            "--check: expected no --csv beside it", "--check: expected no --duration beside it")
        result = self.run_tool("simulate", "--check", "--method", "rk4")
        self.assertEqual((result.returncode, result.stdout), (0, "no faults: 2 links, 0 loads, method rk4\n"), result.stderr)
        self.assert_refused(self.run_tool("simulate", "--check", scene=SCENE.replace("mass: 1", "mass: -1")),
                            "links/upper/mass", "links/lower/mass")

    def test_a_summary_without_csv(self):
        result = self.run_tool("simulate", "--duration", "1")
        self.assertEqual(result.returncode, 0)
        for word in ("t = 1 s", "upper_joint", "energy", "steps"):
            self.assertIn(word, result.stdout)
        self.assertEqual(result.stderr, "")

    def test_progress_on_a_terminal_only(self):
        self.assertEqual(self.simulate("--duration", "1").stderr, "")
        master, terminal = pty.openpty()
        subprocess.run([os.path.join(BIN, "simulate"), self.path("scene.yaml"), "--duration", "1"],
                       stdout=subprocess.DEVNULL, stderr=terminal, timeout=60)
        os.close(terminal)
        self.assertIn(b"of 1 s", os.read(master, 4096))
        os.close(master)

    # ---- equations -------------------------------------------------------------------------------

    def equations(self, *arguments, scene=SCENE):
        result = self.run_tool("equations", "--json", *arguments, scene=scene)
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(result.stdout)

    def test_shapes(self):
        at = self.equations()
        for key, shape in {"S": (2, 2, 2), "T": (2, 2), "V_pd": (2, 4), "W_pd": (2, 2), "A_1": (2, 4),
                           "A_2": (2, 4), "A_3": (2, 2), "M": (2, 2)}.items():
            entry = at[key]
            for size in shape:
                self.assertEqual(len(entry), size, key)
                entry = entry[0]
        for key in ("q", "qd", "f_ext", "f", "qdd"):
            self.assertEqual(len(at[key]), 2, key)

    def test_values_worked_out_by_hand(self):
        # One rod about its pin: M = I + m/4 = 0.35, f = −g/2 cos q.
        rod = f"chain: [l]\nlinks: {{l: {ROD}}}\n"
        at = self.equations("--q", "0.5", scene=rod)
        self.assertAlmostEqual(at["M"][0][0], 0.35, 14)
        self.assertAlmostEqual(at["f"][0], -9.81 / 2 * math.cos(0.5), 13)
        self.assertAlmostEqual(at["qdd"][0], at["f"][0] / at["M"][0][0], 13)
        self.assertEqual(at["S"][0], [[math.cos(0.5), math.sin(0.5)], [-math.sin(0.5), math.cos(0.5)]])

    def test_the_linear_model_is_shown_when_asked_for(self):
        rod = f"chain: [l]\nlinks: {{l: {ROD}}}\n"
        at = self.equations("--q", "0.5", "--linearize", scene=rod)
        self.assertEqual((at["A"][0], at["B"][0]), ([0, 1], [0]))
        self.assertAlmostEqual(at["A"][1][0], 9.81 / 2 * math.sin(0.5) / 0.35, 13)
        self.assertEqual(at["A"][1][1], 0)
        self.assertNotIn("tau_0", at)
        held = self.equations("--q", "0.5", "--linearize", "--tau", "holding", scene=rod)
        self.assertAlmostEqual(held["tau_0"][0], 9.81 / 2 * math.cos(0.5), 13)
        self.assertAlmostEqual(held["qdd_0"][0], 0, 13)
        self.assertAlmostEqual(at["B"][1][0], 1 / 0.35, 14)
        self.assertNotIn("A", self.equations(scene=rod))
        plain = self.run_tool("equations", "--linearize")
        self.assertIn("A   dx/dt = A x + B dtau", plain.stdout)
        self.assertIn("note: this state is no equilibrium", plain.stderr)
        for key in ("command_delay: 0.01", "motor: {time_constant: 0.1}"):
            told = self.run_tool("equations", "--linearize", scene=rod.replace("}}", ", joint: {" + key + "}}}"))
            self.assertIn("A and B leave out the motors and command delays of", told.stderr)

    def test_what_is_not_finite_is_not_printed(self):
        rod = f"chain: [l]\nlinks: {{l: {ROD}}}\n"
        bent = ("--q", "0.3,0.4")
        driven = rod.replace("}}", ", joint: {drive: {amplitude: 1, frequency: 1000}}}}")
        for scene, arguments, what in ((rod, ("--qd", "1e160", "--linearize"), "numbers of A"),
                                       (rod, ("--qd", "1e160", "--linearize", "--json"), "numbers of A"),
                                       (driven, ("--t", "1e308", "--chain"), "angles"),
                                       (SCENE, (*bent, "--qd", "1e160,1", "--json"), "numbers of f"),
                                       (SCENE, (*bent, "--qd", "1e308,1e308"), "numbers of A_1"),
                                       (SCENE, (*bent, "--inverse", "--qdd", "1e308,1e308", "--json"), "torques")):
            result = self.run_tool("equations", *arguments, scene=scene)
            self.assertEqual((result.returncode, result.stdout, result.stderr),
                             (1, "", f"equations: the {what} are not finite: the numbers are too large\n"))

    def test_the_state_is_the_scenes_unless_given(self):
        at = self.equations(scene=SCENE.replace("pin: [1, 0]}", "pin: [1, 0], initial: {angle: 0.2}}", 1))
        self.assertEqual(at["q"], [0.2, 0])

    def test_negative_numbers_come_first(self):
        for arguments in (["--q", "-0.5,0.3"], ["--q=-0.5,0.3"], ["--q", "-.5, 3e-1"]):
            self.assertEqual(self.equations(*arguments)["q"], [-0.5, 0.3])
        self.assertEqual(self.equations("--qd", "-1,2")["qd"], [-1, 2])

    def test_time_drives_the_loads(self):
        pushed = SCENE + "loads: {p: {joint: lower_joint, torque: 3, start: 1}}\n"
        self.assertEqual(self.equations(scene=pushed)["tau"], [0, 0])
        self.assertEqual(self.equations("--t", "1", scene=pushed)["tau"], [0, 3])

    def test_wrong_states_are_refused(self):
        for given in ("1", "1,2,3", "1,x", "1,2,", "1,nan"):
            self.assert_refused(self.run_tool("equations", f"--q={given}"), "--q: expected 2 finite numbers")
        self.assert_refused(self.run_tool("equations", "--q", "1", "--qd", "1"), "--q:", "--qd:")
        self.assert_refused(self.run_tool("equations", "--t", "later"), "--t:")
        self.assert_refused(self.run_tool("equations", "--qdd", "1,2"), "--qdd: expected --inverse beside it")
        self.assert_refused(self.run_tool("equations", "--equilibrium", "--qd", "0,1"), "--qd: expected 0 or none")
        still, at_rest = (self.run_tool("equations", *more) for more in (("--inverse",), ("--inverse", "--qdd", "0,0")))
        self.assertEqual((still.returncode, still.stdout), (0, at_rest.stdout))
        self.assertEqual(self.run_tool("equations", "--equilibrium", "--qd", "0,0").returncode, 0)

    def test_text_shows_every_letter(self):
        result = self.run_tool("equations")
        self.assertEqual(result.returncode, 0)
        first_words = {line.split()[0] for line in result.stdout.splitlines() if line.strip()}
        self.assertLessEqual({"q", "qd", "S_10", "S_20", "T", "V_pd", "W_pd", "A_1", "A_2", "A_3", "F",
                              "M_ext", "tau", "f_ext", "f", "M", "qdd"}, first_words)

    def test_the_chain_is_written_out(self):
        scene = ("chain: [rope, hook]\ngravity: [1, -2]\nlinks:\n"
                 "  rope: {mass: 1e-1, inertia: 0, com: [0.5, 0], pin: ['1', 0], repeat: 2,\n"
                 "         joint: {damping: 3, lower: -1, stop_stiffness: 9}, initial: {angle: 0.2}}\n"
                 "  hook: {mass: 2, inertia: 1, com: [0, 0.5], pin: [0, 0], joint: {name: eye, stiffness: 4, rest_angle: 5}}\n")
        free = {"damping": 0, "stiffness": 0, "rest_angle": 0, "lower": None, "upper": None, "stop_stiffness": 0,
                "stop_damping": 0}
        link = {"mass": 0.1, "inertia": 0, "com": [0.5, 0], "pin": [1, 0]}
        held = {**free, "damping": 3, "lower": -1, "stop_stiffness": 9}
        result = self.run_tool("equations", "--chain", "--qd", "1,2,3", scene=scene)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(json.loads(result.stdout), {
            "gravity": [1, -2], "q": [0.2, 0.2, 0], "qd": [1, 2, 3], "links": [
                {**link, "name": "rope_1", "joint": {**held, "name": "rope_1_joint"}},
                {**link, "name": "rope_2", "joint": {**held, "name": "rope_2_joint"}},
                {"name": "hook", "mass": 2, "inertia": 1, "com": [0, 0.5], "pin": [0, 0],
                 "joint": {**free, "name": "eye", "stiffness": 4, "rest_angle": 5}}]})

    def test_the_chain_has_loads_drives_and_base(self):
        scene = ("chain: [a, b]\nlinks:\n  a: {mass: 1, inertia: 1, com: [0, 0], pin: [1, 0], joint: {drive: hold}}\n"
                 "  b: {mass: 1, inertia: 1, com: [0, 0], pin: [1, 0], joint: {drive: {times: [0, 1], values: [0.5, 2]}}}\n"
                 "base: {x: {amplitude: 0.1, frequency: 0.3}}\n"
                 "loads: {push: {link: b, force: [1, 2], times: [0, 1], values: [0, 1]}, turn: {link: a, moment: 3, frequency: 2}}\n")
        told = json.loads(self.run_tool("equations", "--chain", scene=scene).stdout)
        still = {"amplitude": 0, "frequency": 0, "phase": 0, "offset": 0}
        self.assertEqual([link["joint"]["drive"] for link in told["links"]],
                         [still, {"times": [0, 1], "values": [0.5, 2]}])
        self.assertEqual(told["base"], {"x": {**still, "amplitude": 0.1, "frequency": 0.3}, "y": still, "angle": still})
        self.assertEqual(told["loads"], {
            "push": {"link": "b", "force": [1, 2], "point": [0, 0], "moment": 0, "times": [0, 1], "values": [0, 1],
                     "start": 0, "stop": None},
            "turn": {"link": "a", "force": [0, 0], "point": [0, 0], "moment": 3, "frequency": 2, "phase": 0,
                     "start": 0, "stop": None}})
        # The state of a driven joint is that of its law.
        self.assertEqual(self.run_tool("equations", "--q", "0,0.5", scene=scene).returncode, 0)
        self.assert_refused(self.run_tool("equations", "--q", "0.1,0.5", "--qd", "0,1", scene=scene),
                            "--q: expected 0 rad of the driven joint a_joint at t = 0 s, got 0.1",
                            "--qd: expected 0 rad/s of the driven joint b_joint at t = 0 s, got 1")

    def test_the_chain_has_its_tip(self):
        rods = "chain: [a]\nlinks: {a: {mass: 1, inertia: 1, com: [0, 0], pin: [1, 0], repeat: 3, initial: {angle: 0.5}}}\ntip: "
        told = json.loads(self.run_tool("equations", "--chain", scene=rods + "{pin: {x: {amplitude: 0.1, frequency: 2, offset: 1}, "
                                        "y: {offset: 0.5}}}\n").stdout)
        law = {"amplitude": 0, "frequency": 0, "phase": 0}
        self.assertEqual(told["tip"], {"pin": {"x": {"amplitude": 0.1, "frequency": 2, "phase": 0, "offset": 1},
                                               "y": {**law, "offset": 0.5}}})
        told = json.loads(self.run_tool("equations", "--chain", scene=rods + "{line: {point: [1, 0.5], direction: [0, 2]}}\n").stdout)
        self.assertEqual(told["tip"], {"line": {"point": [1, 0.5], "direction": [0, 1]}})

    def test_the_chain_of_a_robot_is_written_out(self):
        told = json.loads(self.run_robot("equations", "--chain").stdout)
        self.assertEqual([told[key] for key in ("gravity", "q", "qd")], [[0, -9.81], [0], [0]])
        link, = told["links"]
        self.assertEqual((link["name"], link["mass"], link["com"], link["joint"]["name"]), ("rod", 2, [0, -0.5], "pin"))
        self.assertAlmostEqual(link["inertia"], 0.25, delta=1e-15)

    def test_the_chain_comes_alone(self):
        for other in ("--json", "--linearize", "--inverse"):
            self.assert_refused(self.run_tool("equations", "--chain", other), "--chain", other)
        self.assert_refused(self.run_tool("equations", "--inverse", "--linearize"), "--inverse: expected no --linearize beside it")

    def test_dense_matrices_have_a_limit(self):
        long = f"chain: [l]\nlinks: {{l: {ROD[:-1]}, repeat: 100000}}}}\n"
        self.assert_refused(self.run_tool("equations", scene=long), "at most 1000 links")
        chain = json.loads(self.run_tool("equations", "--chain", scene=long).stdout)
        self.assertEqual(len(chain["links"]), 100000)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    BIN = sys.argv.pop(1)
    faulthandler.dump_traceback_later(250, exit=True)  # says where it hangs, before ctest ends it
    unittest.main()
