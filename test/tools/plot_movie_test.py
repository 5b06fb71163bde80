#!/usr/bin/python3
"""plot --movie and animate(): what their pictures show, at which pace, and what they refuse. A page is played by Chromium.

    plot_movie_test.py BIN [unittest options]        BIN: the folder that holds simulate, equations and plot
"""
import base64
import html
import io
import json
import os
import re
import shutil
import subprocess
import time
import unittest
import urllib.request

import numpy as np
from PIL import Image

from plot_tool import BIN, PlotTool, body_of, plot
from browser import browser
from drawing.movie import DPI, FPS, Movie

BLUE, ORANGE = (0, 114, 178), (213, 94, 0)


def pixels_of(picture, colour):
    """Rows and columns of what has about this colour."""
    return np.nonzero(abs(np.asarray(picture.convert("RGB"), dtype=int) - colour).max(axis=2) < 40)


class Movies(PlotTool):
    def recording(self, scene="double_pendulum", duration="0.4", kind="csv"):
        path = self.path(f"{scene}.{kind}")
        run = self.run_tool("simulate", scene, "--duration", duration, f"--{kind}", path)
        self.assertEqual(run.returncode, 0, run.stderr)
        return path

    def movie(self, *arguments):
        run = self.run_tool("plot", *arguments)
        self.assertEqual((run.returncode, run.stderr), (0, ""))

    def test_a_gif_goes_at_the_true_pace(self):
        table, movie = self.recording(), self.path("run.gif")
        for speed, pictures in (("1", 11), ("0.5", 21), ("2", 6)):
            self.movie(table, "--scene", "double_pendulum", "--movie", movie, "--speed", speed)
            with Image.open(movie) as gif:
                self.assertEqual((gif.n_frames, gif.info["loop"]), (pictures, 0))
                lasts = 0
                for k in range(gif.n_frames):
                    gif.seek(k)
                    lasts += gif.info["duration"]
            self.assertEqual(lasts, 40 * pictures)  # ms; 25 pictures a second

    def test_pictures_show_the_chain_where_it_is(self):
        table, body = self.recording("cart_pole", "0.8"), body_of("cart_pole")
        track = plot.read_csv(table).track(body)
        movie = Movie([track], ["a title"], [{"the tip": body.point("tip")}])
        axes = movie.panels[0].pose.artists["links"].axes
        for k in (0, 20):
            movie._show(k)
            height = movie.picture().size[1]
            places = track.at([k / FPS])
            for point in places.points[0]:
                x, y = axes.transData.transform((point.real, point.imag))
                rows, columns = (np.concatenate(pair) for pair in zip(*(pixels_of(movie.picture(), colour) for colour in (BLUE, ORANGE))))
                self.assertLess(np.hypot(rows - (height - y), columns - x).min(), 2, (k, point))
        self.assertEqual(movie.clock.get_text(), "t = 0.80 s")
        fast = Movie([track], [""], [{}], speed=2.0)
        np.testing.assert_allclose(fast.panels[0].times, 0.08 * np.arange(11), atol=1e-12)
        self.assertFalse(fast.panels[0].trails)
        # The path ends at the tip, and begins anew after an event.
        trail = movie.panels[0].trails[0][0].get_xydata()
        self.assertAlmostEqual(complex(*trail[-1]), places.points[0, -1], delta=1e-12)
        track.events = [30]
        movie = Movie([track], [""], [{"the tip": body.point("tip")}])
        movie._show(20)
        self.assertEqual(np.isnan(movie.panels[0].trails[0][0].get_xdata()).sum(), 1)

    def test_several_motions_side_by_side_of_bags_and_tables(self):
        bag, table, movie = self.recording("crane", "0.2", "bag"), self.recording("bungee", "0.3"), self.path("both.gif")
        self.movie(bag, table, "--scene", "crane", "--scene", "bungee", "--movie", movie, "--dark")
        one = self.path("one.gif")
        self.movie(bag, "--movie", one, "--point", "load,0,0", "tip")  # a bag brings its scene
        with Image.open(movie) as both, Image.open(one) as single:
            self.assertEqual((both.n_frames, single.n_frames), (9, 6))  # as long as the longest
            self.assertGreater(both.size[0], 1.5 * single.size[0])
            self.assertEqual(both.convert("RGB").getpixel((0, 0)), (0, 0, 0))
        self.assertEqual(single.size[0] % 2, 0)

    def test_an_mp4_needs_ffmpeg(self):
        table, movie = self.recording(), self.path("run.mp4")
        run = subprocess.run(["/usr/bin/python3", os.path.join(BIN, "plot"), table, "--scene", "double_pendulum", "--movie", movie],
                             env={**os.environ, "PATH": self.folder}, stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True, check=False)
        self.assertEqual((run.returncode, run.stderr), (2, "plot: --movie: a .mp4 needs the program ffmpeg, which is not installed (Debian, "
                                                        "Ubuntu: apt install ffmpeg); .gif and .html do not\n"))
        self.assertFalse(os.path.exists(movie))
        if shutil.which("ffmpeg") is None:
            self.skipTest("ffmpeg is not installed")
        self.movie(table, "--scene", "double_pendulum", "--movie", movie)
        known = subprocess.run(["ffprobe", "-v", "error", "-show_entries", "stream=nb_frames,duration", "-of", "csv=p=0", movie], check=True,
                               stdout=subprocess.PIPE, universal_newlines=True).stdout
        self.assertEqual(known.strip(), "0.440000,11")

    def test_a_page_plays_without_a_network(self):
        table, movie = self.recording(duration="2"), self.path("run.html")
        self.movie(table, "--scene", "double_pendulum", "--movie", movie)
        with open(movie, encoding="utf-8") as file:
            self.assertIsNone(re.search(r"https?:|src=|href=|@\w+@", file.read()))
        if shutil.which("chromedriver") is None:
            self.skipTest("Debian's chromium and chromium-driver are not installed")
        with browser() as call:
            call("POST", "/url", url="file://" + urllib.request.pathname2url(movie))
            shots = []
            for _ in range(2):
                shown = -1
                while shown < 0:  # until it plays
                    shown, now = call("POST", "/execute/sync", script="return [shown, performance.now() - start]", args=[])
                self.assertLess(abs((now / 40 - shown + 25) % 51 - 25), 4)  # at the true pace, up to the pictures that it leaves out
                shots.append((shown, Image.open(io.BytesIO(base64.b64decode(call("GET", "/screenshot"))))))
                time.sleep(0.3)
            call("POST", "/execute/sync", script="button.click()", args=[])
            stopped = [call("POST", "/execute/sync", script="return shown", args=[]) for _ in range(2)]
        self.assertNotEqual(shots[0][0], shots[1][0])
        self.assertEqual(*stopped)
        # Two pictures of the same place: the link is in both, and has moved.
        links = [set(zip(*pixels_of(picture, BLUE))) for _, picture in shots]
        self.assertGreater(min(map(len, links)), 100)
        self.assertGreater(len(links[0] - links[1]), 50)

    def test_what_cannot_be_a_movie_is_refused(self):
        table, movie = self.recording(), self.path("run.gif")
        with open(movie, "w", encoding="utf-8") as file:
            file.write("as it was")
        for more, fault in ((["--movie", movie], "--movie: expected --scene SCENE beside a recording without one, got none"),
                            (["--movie", movie, "--scene", "triple"], "--movie: expected the scene of upper_joint, lower_joint, got that of"),
                            (["--movie", self.path("run.avi")], "--movie: expected a name that ends in .gif, .mp4 or .html, got"),
                            (["--movie", movie, "--wrap"], "--movie: expected no --wrap beside it, got both"),
                            (["--movie", movie, "--scene", "double_pendulum", "--speed", "0"], "--speed: expected a number above 0, got 0.0"),
                            (["--movie", movie, "--scene", "double_pendulum", "--speed", "1e-4"], "--movie: expected at most 300 s, got 4000 s"),
                            (["--speed", "2"], "--speed: expected --movie FILE beside it, got nothing"),
                            ([table], "expected one file, or --movie FILE beside several"),
                            (["--point", "tip"], "--point: expected --strobe SCENE or --movie FILE beside it, got nothing"),
                            (["--movie", movie, "--scene", "a", "--scene", "b"], "--scene: expected one, or one for each of 1 files, got 2")):
            self.assertIn(fault, self.refused(table, *more))
        self.assertIn("--movie: expected a bag with ~link_states, as the base of the scene moves, got none",
                      self.refused(self.recording("crane", "0.1"), "--scene", "crane", "--movie", movie))
        with open(movie, encoding="utf-8") as file:
            self.assertEqual(file.read(), "as it was")


class Animate(PlotTool):
    def setUp(self):
        super().setUp()
        try:
            import planar_chain
            self.scene, self.animate = planar_chain.Scene.from_file, planar_chain.animate
        except ImportError:
            self.skipTest("there is no Python module")

    def test_it_shows_itself_in_a_notebook_and_saves_itself(self):
        import planar_chain
        scene, times = self.scene("double_pendulum"), np.arange(11) / 50
        movie = self.animate(scene, times, planar_chain.simulate(scene, times), points=["tip", ("upper", [0.5, 0.0])])
        shown = movie._repr_html_()
        page = html.unescape(re.fullmatch(r'<iframe srcdoc="([^"]*)".*</iframe>', shown, re.DOTALL).group(1))
        pictures = json.loads(re.search(r"const pictures = (\[.*?\])", page).group(1))
        self.assertEqual(len(pictures), 6)
        with Image.open(io.BytesIO(base64.b64decode(pictures[0]))) as first:
            self.assertEqual(first.size, tuple(np.round(movie._fig.get_size_inches() * DPI).astype(int)))
        movie.save(self.path("run.gif"))
        with Image.open(self.path("run.gif")) as gif:
            self.assertEqual(gif.n_frames, 6)
        movie.save(self.path("run.gif"), dpi=DPI // 2)
        with Image.open(self.path("run.gif")) as gif:
            np.testing.assert_allclose(gif.size, np.array(first.size) / 2, atol=1)
        with self.assertRaisesRegex(ValueError, r"expected a name that ends in .gif, .mp4 or .html, got run.avi"):
            movie.save("run.avi")

    def test_its_chain_is_where_the_scene_puts_it(self):
        # The base of the crane moves by a law.
        scene, times = self.scene("crane"), np.array([0.0, 1.0, 2.5])
        q = np.random.default_rng(1).normal(scale=0.1, size=(3, len(scene)))
        track = self.animate(scene, times, q).panels[0].track
        for k, t in enumerate(times):
            place = track.at([t]).points[0, -1]
            np.testing.assert_allclose([place.real, place.imag], scene.position("tip", q[k], t=t), atol=1e-12)

    def test_its_arguments_are_checked(self):
        scene = self.scene("double_pendulum")
        for times, states, more, fault in (([0.0], np.zeros((1, 2)), {}, "times: expected two or more that rise"),
                                           ([0.0, 0.0], np.zeros((2, 2)), {}, "times: expected two or more that rise"),
                                           ([0.0, 1.0], np.zeros((2, 3)), {}, "states: expected 2 rows of 2 or 4 finite numbers, got an array of shape"),
                                           ([0.0, 1.0], np.full((2, 2), np.nan), {}, "states: expected 2 rows of 2 or 4 finite numbers"),
                                           ([0.0, 1.0], np.zeros((2, 2)), {"speed": 0}, "speed: expected a number above 0, got 0"),
                                           ([0.0, 1.0], np.zeros((2, 2)), {"points": ["elbow"]}, "points: expected tip, a frame of")):
            with self.assertRaisesRegex(ValueError, fault):
                self.animate(scene, times, states, **more)


if __name__ == "__main__":
    unittest.main()
