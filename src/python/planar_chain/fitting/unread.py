"""Bags, for plot and show."""

ENDINGS = ".bag", ".bag.active"  # active: it is being recorded, or its recorder was killed


def why_unread(path, problem):
    """Why rosbag or the system cannot read this bag, and the remedy. The same words stand in fitting/bags.py and in
    recorded_commands.cpp."""
    from rosbag import ROSBagUnindexedException
    if isinstance(problem, ROSBagUnindexedException):
        return f"one without an index; its recorder still runs or was killed (to mend it: rosbag reindex {path})"
    return f"nothing: {problem.strerror}" if isinstance(problem, OSError) else str(problem)
