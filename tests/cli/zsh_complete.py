#!/usr/bin/env python3
"""What zsh makes of a line and the tab key: python3 zsh_complete.py FOLDER LINE... prints each line as completed.

FOLDER holds the completion file _talus. A zsh without start files runs in a pseudo terminal, as a user's would.
"""
import os
import pty
import select
import sys
import time

LIMIT = 60  # [s] until the shell must have answered


def read_until(fd, mark):
    data, end = b"", time.monotonic() + LIMIT
    while mark not in data:
        left = end - time.monotonic()
        if left <= 0 or not select.select([fd], [], [], left)[0]:
            sys.exit(f"zsh did not answer: {data!r}")
        data += os.read(fd, 65536)
    return data


def main():
    folder, lines = os.path.abspath(sys.argv[1]), sys.argv[2:]
    child, fd = pty.fork()
    if child == 0:
        os.environ.update(TERM="dumb", ZDOTDIR=folder, LC_ALL="C")
        os.execvp("zsh", ["zsh", "-f", "-i"])
    # A widget completes the line and says what it then holds; with an ambiguous one the common part is what counts.
    setup = (f"fpath=('{folder}' $fpath); autoload -Uz compinit; compinit -u -D; unsetopt auto_list beep; PS1=; "
             "say() { zle expand-or-complete; print -r -- \"[$BUFFER]\"; BUFFER=; zle -R; }; zle -N say; "
             "bindkey '^T' say; print re''ady\n")
    os.write(fd, setup.encode())
    read_until(fd, b"ready\r\n")
    for line in lines:
        os.write(fd, line.encode() + b"\x14")
        seen = read_until(fd, b"]\r\n")
        print(seen[seen.rindex(b"[") + 1:seen.rindex(b"]")].decode())
    os.write(fd, b"exit\n")


if __name__ == "__main__":
    main()
