"""Bags that cannot be read: for fits, and by a link for the tools plot and show."""

ENDINGS = ".bag", ".bag.active"  # active: it is being recorded, or its recorder was killed


def why_unread(path, problem):
    """Why rosbag or the system cannot read this bag, and the remedy. recorded_commands.cpp says the same."""
    from rosbag import ROSBagUnindexedException  # pylint: disable=import-outside-toplevel
    if isinstance(problem, ROSBagUnindexedException):
        return f"one without an index; its recorder still runs or was killed (to mend it: rosbag reindex {path})"
    return f"nothing: {problem.strerror}" if isinstance(problem, OSError) else str(problem)
