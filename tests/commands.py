"""Commands that tests run, and the texts that they print; nothing else is imported here."""

import subprocess


def finished(command, *, code=0, **options):
    """Run a program and return its result; its exit code must be ``code``."""
    words = [str(word) for word in command]
    done = subprocess.run(words, capture_output=True, text=True, check=False, **options)
    assert done.returncode == code, done.stdout[-3000:] + done.stderr[-3000:]
    return done


def flat(text):
    """The words of a text on one line."""
    return " ".join(text.split())
