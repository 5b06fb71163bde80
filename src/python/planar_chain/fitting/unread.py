"""Bags that are read, or why they cannot be: for fits, and by a link for the tools plot and show."""

import contextlib
import io

ENDINGS = ".bag", ".bag.active"  # active: it is being recorded, or its recorder was killed


@contextlib.contextmanager
def opened(path, refused):
    """Within it, gives a rosbag.Bag and messages_of(topic or None, type), a list. Raises `refused` with the reason if the bag cannot be
    read, or has another type, or defines it otherwise."""
    try:
        import rosbag  # pylint: disable=import-outside-toplevel  # a CSV needs no ROS
        from genpy.message import get_message_class  # pylint: disable=import-outside-toplevel
    except ImportError as missing:
        raise refused(f"{path}: a bag needs ROS's rosbag for Python: {missing}") from None

    def messages_of(topic, kind):
        with contextlib.redirect_stderr(io.StringIO()):  # rosbag warns of definitions that are refused here
            messages = [message for _, message, _ in bag.read_messages(topic)] if topic else []
        present = get_message_class(kind)
        for its in {type(message) for message in messages}:
            if its._type != kind:
                raise refused(f"{path}: expected {topic} of type {kind}, got {its._type}")
            if present and its._md5sum != present._md5sum:
                raise refused(f"{path}: expected {topic} of type {kind} as this version defines it, got a definition that is damaged, or "
                              "that of another version, which `rosbag fix` converts (msg/README.md)")
        return messages

    try:
        with rosbag.Bag(path) as bag:
            yield bag, messages_of
    except refused:
        raise
    except Exception as problem:  # pylint: disable=broad-except  # a damaged bag raises any
        raise refused(f"{path}: expected a bag that can be read, got {why_unread(path, problem)}") from problem


def full(name):
    """rosbag keeps relative names."""
    return "/" + name.lstrip("/")


def topics_of(bag, path, node, refused):
    """The topic joint_states of one node, and its name, or None if the bag has no ~status of it. node: its name, or None for the only
    one."""
    topics = bag.get_type_and_topic_info().topics
    states, nodes = (sorted(topic[:length] for topic, about in topics.items() if about.msg_type == kind and full(topic).endswith(name))
                     for kind, name, length in (("sensor_msgs/JointState", "/joint_states", None),  # an encoder publishes JointState too
                                                ("planar_chain/SimStatus", "/status", -len("/status"))))
    if node is not None:
        name = full(node.rstrip("/"))
        if name not in (list(map(full, nodes)) or [name]) or name == "/":
            there = f" of {path} ({', '.join(nodes)})" if nodes else ""
            raise refused(f"--node: expected a node{there}, got {node or 'nothing'}")
        states = [topic for topic in states if full(topic) == name.rpartition("/")[0] + "/joint_states"]
        nodes = [one for one in nodes if full(one) == name]
    if len(states) != 1 or len(nodes) > 1:
        which = "of one node (choose it with --node)" if node is None else "of " + node
        raise refused(f"{path}: expected joint_states {which}, got {', '.join(states + nodes) or ('neither' if topics else 'a bag without messages')}")
    return states[0], nodes[0] if nodes else None


def why_unread(path, problem):
    """Why rosbag or the system cannot read this bag, and the remedy. recorded_commands.cpp says the same."""
    from rosbag import ROSBagUnindexedException  # pylint: disable=import-outside-toplevel
    if isinstance(problem, ROSBagUnindexedException):
        return f"one without an index; its recorder still runs or was killed (to mend it: rosbag reindex {path})"
    if isinstance(problem, OSError) and problem.strerror:
        return f"nothing: {problem.strerror}"
    with open(path, "rb") as file:
        beginning = file.read(7)
    if beginning != b"#ROSBAG":
        return "a file that is no bag" if beginning else "an empty file"
    return f"a damaged one ({' '.join(str(problem).split()) or type(problem).__name__})"
