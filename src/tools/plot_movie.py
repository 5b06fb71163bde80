"""Writes motions as a picture that moves. For plot."""

import sys

from drawing.movie import KINDS, Movie, NoWriter, write, writer_of
from files import BadOutput, writing

LONGEST = 300  # s


def require_movie(option, path):
    """Raises BadOutput for a name that is no movie's, or if what it needs is not there."""
    if not path.endswith(KINDS):
        raise BadOutput(f"{option}: expected a name that ends in .gif, .mp4 or .html, got {path}")
    try:
        writer_of(path)
    except NoWriter as problem:
        raise BadOutput(f"{option}: {problem}") from problem


def show_progress(done, pictures):
    if sys.stderr.isatty():
        bar = "#" * (40 * done // pictures)
        sys.stderr.write(f"\r[{bar:.<40}] {done} of {pictures} pictures\033[K" if done + 1 < pictures else "\r\033[K")
        sys.stderr.flush()


def movie_of(tracks, titles, points, speed):
    """points: of Body.point(), by their names, for each track."""
    longest = max(track.t[-1] - track.t[0] for track in tracks) / speed
    if not longest <= LONGEST:
        raise BadOutput(f"--movie: expected at most {LONGEST} s, got {longest:g} s (--speed, --from and --to shorten it)")
    return Movie(tracks, titles, points, speed)


def save_movie(movie, path):
    with writing(path):
        write(movie, path, show_progress)
