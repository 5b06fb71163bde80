#!/usr/bin/python3
"""plot --strobe: where it draws the chain, its marks and its words, what it refuses.

    plot_strobe_test.py BIN [unittest options]        BIN: the folder that holds simulate, equations and plot
"""
import os
import unittest

import numpy as np
import yaml

from plot_tool import JOINTS, SCENE, SCENES, PlotTool, body_of, plot, plot_read, read_chain
from drawing.body import Body, Places, spans_of
from drawing.poses import in_view, lines_of


def pins(body, base, q):
    places = Places(body, base, q)
    return places.points, places.coms, places.own


class Strobe(PlotTool):
    def test_strobe_puts_pins_where_the_links_end(self):
        links = body_of(SCENE)
        self.assertEqual(links.joints, JOINTS)
        with open(SCENE, encoding="utf-8") as file:
            scene = yaml.safe_load(file)
        q = np.array([[0.3, -0.7, 1.9], [0.0, 0.0, 0.0]])
        base = np.array([[0.0, 0.0, 0.0], [3.0, -1.0, 0.4]])
        for at, row, points, coms, starts in zip(base, q, *pins(links, base, q)):
            np.testing.assert_array_equal(starts, points[:-1])
            pin, theta = at[:2], at[2]
            for k, name in enumerate(scene["chain"]):
                theta += row[k]
                turn = np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]])
                np.testing.assert_allclose([points[k].real, points[k].imag], pin, atol=1e-15)
                com = pin + turn @ scene["links"][name]["com"]
                np.testing.assert_allclose([coms[k].real, coms[k].imag], com, atol=1e-15)
                pin = pin + turn @ scene["links"][name]["pin"]
            np.testing.assert_allclose([points[-1].real, points[-1].imag], pin, atol=1e-15)

    def test_strobe_begins_where_the_chain_turns(self):
        base, q = np.zeros((1, 3)), np.array([[3.0, 0.5]])
        points, _, starts = pins(body_of(os.path.join(SCENES, "cart_pole.yaml")), base, q)
        np.testing.assert_allclose(points[0], [3 + 0.1j, 3 + 0.1j + 0.5 * np.exp(0.5j)], atol=1e-15)
        self.assertEqual(list(starts[0]), [3, points[0, 0]])
        free = body_of(os.path.join(SCENES, "thrown.yaml"))
        points = pins(free, base, np.array([[3.0, 4.0, 0.1, 0, 0, 0]]))[0]
        np.testing.assert_allclose(points[0], 3 + 4j + 0.6 * np.arange(5) * np.exp(0.1j), atol=1e-14)
        self.assertEqual((free.leading, free.carts), (2, 0))

    def test_strobe_draws_springs_to_the_ground_and_frames(self):
        scene, table = self.path("tied.yaml"), self.path("run.csv")
        arm = {"mass": 1, "inertia": 0.1, "com": [0.3, 0], "pin": [0.6, 0]}
        spring = {"link": "b", "point": [0.1, 0.2], "ground": [1, -2], "stiffness": 10}
        frames = {"gripper": {"link": "b", "point": [0.5, 0.1], "angle": 1.0}, "elbow": {"link": "a", "point": [0.6, 0]}}
        with open(scene, "w", encoding="utf-8") as file:
            yaml.safe_dump({"chain": ["a", "b"], "links": {"a": arm, "b": arm}, "springs": {"rope": spring}, "frames": frames}, file)
        body = body_of(scene)
        places = Places(body, np.zeros((1, 3)), np.array([[0.3, 0.5]]))
        elbow, turn = 0.6 * np.exp(0.3j), np.exp(0.8j)
        for name, place in {"gripper": elbow + turn * (0.5 + 0.1j), "elbow": elbow}.items():
            self.assertAlmostEqual(places.of(*body.point(name))[0], place, delta=1e-15)
            self.assertLess(abs(lines_of(places, 1.0)["frames"][0] - place).min(), 1e-15)
        np.testing.assert_allclose(places.spring_ends(), [[[1 - 2j]], [[elbow + turn * (0.1 + 0.2j)]]], atol=1e-15)
        self.assertEqual(self.run_tool("simulate", scene, "--duration", "0.2", "--csv", table).returncode, 0)
        figure = plot.strobe(plot.read_csv(table), scene, [0.0, 0.2], 2.0, "", ["gripper"])
        self.assertLessEqual({"spring", "frame", "path of gripper"}, {text.get_text() for text in figure.legends[0].get_texts()})
        anchors = [line.get_xydata().ravel().tolist() for line in figure.axes[0].lines if line.get_markersize() == 5]
        self.assertEqual(anchors, [[1, -2], [3, -2]])

    def test_strobe_draws_a_telescope_along_its_axis(self):
        scene = self.path("telescope.yaml")
        arm, rod = {"mass": 1, "inertia": 0.1, "com": [0.3, 0], "pin": [0.6, 0.1]}, {"mass": 1, "inertia": 0.1, "com": [-0.1, 0], "pin": [0.3, 0]}
        joint = {"type": "prismatic", "axis": [3, 4], "lower": -0.2, "stop_stiffness": 1000.0}
        with open(scene, "w", encoding="utf-8") as file:
            yaml.safe_dump({"chain": ["arm", "rod", "tool"], "links": {"arm": arm, "rod": {**rod, "joint": joint}, "tool": arm}}, file)
        links, q = body_of(scene), np.array([[0.7, 0.5, -0.4], [0.7, 0.0, -0.4]])
        points, coms, starts = pins(links, np.zeros((2, 3)), q)
        turn, axis = np.exp(0.7j), 0.6 + 0.8j
        own = turn * (0.6 + 0.1j + 0.5 * axis)
        np.testing.assert_allclose(points[0], [0, turn * (0.6 + 0.1j), own + 0.3 * turn, own + 0.3 * turn + np.exp(0.3j) * (0.6 + 0.1j)], atol=1e-15)
        np.testing.assert_allclose([starts[0, 1], coms[0, 1]], [own, own - 0.1 * turn], atol=1e-15)
        spans = spans_of(links, q)[1:2]
        np.testing.assert_allclose(spans, [[-0.2, 0.5]], atol=1e-15)  # from the limit to where it gets
        np.testing.assert_allclose(Places(links, np.zeros((2, 3)), q, spans=spans_of(links, q)).axes([1])[:, 0],
                                   [[turn * (0.6 + 0.1j - 0.2 * axis), own]] * 2, atol=1e-15)
        # On a base that turns, a cart's axis turns with it.
        cart = body_of(os.path.join(SCENES, "cart_pole.yaml"))
        base, motion = np.array([[3.0, 1.0, 0.5]]), plot_read.Motion(["cart", "pole"], np.zeros(1), np.array([[2.0, 0.3]]), np.zeros((1, 2)))
        com = pins(cart, base, motion.q)[1][0, 0]
        cart.moves, motion.first = True, np.array([[com.real, com.imag, 0.5]])
        np.testing.assert_allclose(motion.track(cart).base, base, atol=1e-15)
        self.assertAlmostEqual(abs(com - (3 + 1j) - 2 * np.exp(0.5j)), 0, delta=1e-15)
        table = self.path("run.csv")
        self.assertEqual(self.run_tool("simulate", scene, "--duration", "0.2", "--csv", table).returncode, 0)
        figure = plot.strobe(plot.read_csv(table), scene, [], 0.0, "")
        self.assertIn("prismatic joint", [text.get_text() for text in figure.legends[0].get_texts()])
        self.assertIn(4 + 2, [len(line.get_xdata()) for line in figure.axes[0].lines])  # it begins anew behind the prismatic joint

    def test_strobe_reads_a_urdf(self):
        urdf, table = self.path("scene.urdf"), self.path("run.csv")
        run = self.run_tool("simulate", SCENE, "--duration", "0.1", "--write-urdf", urdf, "--csv", table)
        self.assertEqual(run.returncode, 0, run.stderr)
        scene, robot = body_of(SCENE), body_of(urdf)
        self.assertEqual(robot.joints, scene.joints)
        np.testing.assert_allclose(robot.com, scene.com, atol=1e-15)
        with open(urdf, encoding="utf-8") as file:
            text = file.read()
        hand = '<parent link="hand"/><child link="tool"/><origin xyz="0.5 0 0"/>'
        with open(urdf, "w", encoding="utf-8") as file:
            file.write(text.replace("</robot>", f'<link name="tool"/><joint name="hold" type="fixed">{hand}</joint></robot>'))
        for links, pin, label in ((robot, scene.pin[-1], "path of the tip"), (body_of(urdf), 0.5, "path of the tip")):
            figure = plot.draw_strobe(plot.read_csv(table).track(links), [0.0, 0.1], 0.0, "", plot.points_of(links, []))
            self.assertEqual((links.pin[-1], figure.legends[0].get_texts()[0].get_text()), (pin, label))

    def test_strobe_moves_the_base_as_a_bag_does(self):
        crane, bag, table = os.path.join(SCENES, "crane.yaml"), self.path("crane.bag"), self.path("crane.csv")
        run = self.run_tool("simulate", crane, "--duration", "3", "--bag", bag, "--csv", table)
        self.assertEqual(run.returncode, 0, run.stderr)
        motion, links = plot.read_bag(bag, None), body_of(crane)
        chain = read_chain(crane)
        law = chain["base"]["x"]
        ground = pins(links, motion.track(links).base, motion.q)[0][:, 0]
        # The law is met at its knots, up to half a tick.
        for time, value in zip(law["times"], law["values"]):
            if time < 3:
                self.assertAlmostEqual(ground[np.argmin(abs(motion.t + 0.005 - time))].real, value, delta=0.01)
        self.assertGreater(np.ptp(ground.real), 0.5)
        self.assertEqual(self.run_tool("plot", bag, "--strobe", crane, "--output", self.path("crane.png")).returncode, 0)
        self.assertIn("--strobe: expected a bag with ~link_states", self.refused(table, "--strobe", crane))

    def test_strobe_knows_repeated_links_and_masses_beside_their_link(self):
        links = body_of(os.path.join(SCENES, "throw.yaml"))
        self.assertEqual((links.joints[1], links.joints[9], links.joints[-1]),
                         ("sling_1_joint", "sling_9_joint", "pouch_joint"))
        self.assertEqual(list(links.aside), [0])

    def test_a_strobe_of_what_stands_still_or_is_wide_is_legible(self):
        motion = plot_read.Motion(["a"], np.linspace(0, 1, 5), np.zeros((5, 1)), np.zeros((5, 1)))
        joint = {"name": "a", "lower": None, "upper": None}
        body = Body({"links": [{"name": "a", "pin": [0, -2], "com": [0, -1], "joint": joint}], "gravity": [0, -9.81]})
        for apart in (0.0, 5.0):
            figure = plot.draw_strobe(motion.track(body), np.linspace(0, 1, 5), apart, "a title that is as long as many are.yaml",
                                      {"the tip": body.point("tip")})
            axes, bar = figure.axes
            (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
            self.assertTrue(right - left >= 1 and low < -2 < 0 < high, (left, right, low, high))
            # A metre is as long in x as in y; the title, the axes and the legend lie apart, and on the page.
            figure.canvas.draw()
            box = axes.get_window_extent()
            self.assertAlmostEqual(box.width / (right - left), box.height / (high - low), delta=1e-6 * box.width)
            title, legend = figure._suptitle.get_window_extent(), figure.legends[0].get_window_extent()
            self.assertTrue(title.y0 > box.y1 and legend.y1 < axes.xaxis.label.get_window_extent().y0)
            self.assertTrue(title.y1 < figure.bbox.y1 and legend.y0 > 0 and axes.yaxis.label.get_window_extent().x0 > 0)
            self.assertLess(abs(bar.get_window_extent().height - box.height), 1)
            self.assertEqual(axes.xaxis.get_offset_text().get_text(), "")

    def test_a_strobe_of_a_held_tip_marks_its_pin(self):
        for name, labels in (("four_bar", ["ground pin", "pin of the tip"]), ("slider_crank", ["path of the tip", "ground pin"]),
                             ("cart_pole", ["path of the tip", "cart"]), ("thrown", ["path of the tip"]),
                             ("throw", ["path of the tip", "centre of mass", "ground pin"]),
                             ("jump_rope", ["path of the tip", "ground pin", "pin of the tip"])):
            table = self.path(name + ".csv")
            self.assertEqual(self.run_tool("simulate", name, "--duration", "0.5", "--csv", table).returncode, 0)
            figure = plot.strobe(plot.read_csv(table), os.path.join(SCENES, name + ".yaml"), [], 0.0, "")
            self.assertEqual([text.get_text() for text in figure.legends[0].get_texts()], labels)

    def test_springs_loads_and_rails_are_drawn_where_they_are(self):
        scene = self.path("machine.yaml")
        arm = {"mass": 1, "inertia": 0.1, "com": [0.3, 0], "pin": [0.6, 0.1]}
        along = {"type": "prismatic", "axis": [1, 0], "lower": -2.0, "stop_stiffness": 1e3}
        springs = {"coil": {"link": "arm", "point": [0.5, 0.2], "ground": [1, 2], "stiffness": 9.0},
                   "rope": {"link": "arm", "point": [0, 0], "ground": [0, 3], "stiffness": 9.0, "rest_length": 5.0, "slack": True}}
        loads = {"push": {"link": "arm", "force": [0, 4.0], "point": [0.6, 0.1], "times": [0, 1], "values": [0, 2], "stop": 3},
                 "motor": {"joint": "arm_joint", "torque": -2.0, "start": 1.0}}
        with open(scene, "w", encoding="utf-8") as file:
            yaml.safe_dump({"chain": ["cart", "arm"], "links": {"cart": {**arm, "joint": along}, "arm": arm}, "springs": springs, "loads": loads}, file)
        body, q = body_of(scene), np.array([[0.5, 0.7]] * 3)
        places = Places(body, np.zeros((3, 3)), q, np.array([0.5, 2.0, 3.0]))
        lines, pin, tip = lines_of(places, 1e-3), 1.1 + 0.1j, 1.1 + 0.1j + np.exp(0.7j) * (0.6 + 0.1j)
        ground, end = lines["springs"][0, 0], lines["springs"][0, -2]  # behind it is a gap
        np.testing.assert_allclose([ground, end], [1 + 2j, pin + np.exp(0.7j) * (0.5 + 0.2j)], atol=1e-14)
        rope = lines["ropes"][0, :-1]
        np.testing.assert_allclose([rope[0], rope[-1]], [3j, pin], atol=1e-14)
        self.assertAlmostEqual(np.sum(abs(np.diff(rope))), 5, delta=1e-3)  # as long as at rest
        self.assertLess(rope.imag.min(), 0)                              # it sags
        np.testing.assert_allclose(lines["rails"][0, :2], [-body.reach, 0.5], atol=1e-14)
        # A force that grows to its double, a torque from 1 s on, nothing after the stop. The largest force is a quarter of the reach.
        arrow, arc = lines["loads"][:, :5], lines["loads"][:, 12:]
        np.testing.assert_allclose(arrow[:2, 1] - arrow[:2, 0], [0.125j * body.reach, 0.25j * body.reach], atol=1e-14)
        np.testing.assert_allclose(arrow[0, 0], tip, atol=1e-14)
        self.assertEqual([np.isnan(arrow[k, 1:4]).all() for k in range(3)], [False, False, True])
        self.assertEqual([np.isnan(arc[k]).all() for k in range(3)], [True, False, False])
        self.assertTrue(np.nanmax(abs(arc - pin)) < 0.03)  # around its joint
        seen = in_view(places)
        self.assertTrue(np.isfinite(seen).all() and {1 + 2j, 3j} <= set(seen) and abs(seen - tip - 0.25j * body.reach).min() < 1e-14)

    def test_a_path_of_any_point(self):
        # The middle of the coupler of a four-bar goes around a closed curve. Its ends are on circles.
        table, picture = self.path("bar.csv"), self.path("bar.svg")
        run = self.run_tool("simulate", "four_bar", "--duration", "2", "--csv", table)
        self.assertEqual(run.returncode, 0, run.stderr)
        body, motion = body_of("four_bar"), plot.read_csv(table)
        points = plot.points_of(body, ["coupler,0,0", "coupler,0.5,0.3", "coupler"])
        inner, middle, outer = (motion.track(body).path(*point) for point in points.values())
        np.testing.assert_allclose(abs(inner), abs(body.pin[0]), atol=1e-9)
        np.testing.assert_allclose(abs(outer - inner), abs(body.pin[1]), atol=1e-9)
        np.testing.assert_allclose((middle - inner) / (outer - inner), (0.5 + 0.3j) / body.pin[1], atol=1e-9)
        run = self.run_tool("plot", table, "--strobe", "four_bar", "--point", "coupler,0.5,0.3", "tip", "--output", picture)
        self.assertEqual(run.returncode, 0, run.stderr)
        with open(picture, encoding="utf-8") as file:
            text = file.read()
        self.assertTrue("path of coupler,0.5,0.3" in text and "path of tip" not in text)  # the tip is pinned
        for wrong in ("rod,0,0", "coupler,0", "coupler,a,0", "coupler,0,inf"):
            self.assertIn(f"--point: expected LINK,x,y with a link of crank, coupler, rocker, a frame of the scene, or tip, got {wrong}",
                          self.refused(table, "--strobe", "four_bar", "--point", wrong))

    def test_strobe_is_drawn_and_refuses_what_does_not_fit(self):
        table, picture = self.path("run.csv"), self.path("run.svg")
        self.simulate("--csv", table)
        run = self.run_tool("plot", table, "--strobe", SCENE, "--at", "0", "0.5", "2", "--apart", "1", "--output", picture)
        self.assertEqual(run.returncode, 0, run.stderr)
        with open(picture, encoding="utf-8") as file:
            text = file.read()
        for label in ("x (m)", "y (m)", "time (s)", "path of the tip", "run.csv: triple.yaml"):
            self.assertIn(label, text)
        self.assertIn("expected --strobe SCENE", self.refused(table, "--at", "0", "1"))
        self.assertIn("scene: expected a map", self.refused(table, "--strobe", table))
        motion = plot.read_csv(table)
        for scene, times, apart, fault in (
                (os.path.join(SCENES, "whip.yaml"), [], 0, "--strobe: expected the scene of shoulder_pin"),
                (SCENE, [1.0], 0, "--at: expected two times or more from 0 to 2 s, got 1"),
                (SCENE, [0.0, 2.1], 0, "got 0, 2.1"), (SCENE, [np.nan, 1.0], 0, "got nan, 1"),
                (SCENE, [], 2e9, "got 2000000000.0"), (SCENE, [], np.nan, "got nan"), (SCENE, [1.0, 1.0], 0, "got 1, 1"), (SCENE, [], np.inf, "--apart: expected a number up to 1e+09, got inf")):
            with self.assertRaises(plot.Refused) as refusal:
                plot.strobe(motion, scene, times, apart, "")
            self.assertIn(fault, str(refusal.exception))


if __name__ == "__main__":
    unittest.main()
