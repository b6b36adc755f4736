#!/usr/bin/env bash
# WITH argparse-manpage 4.8 from PyPI, CPython 3.11 or newer
# EXPECTED help texts of an argparse parser appear in the manual page that is made of it: groff_man(7) has an apostrophe
#   or a dot at the begin of a line escaped (\&), since it makes the line a request otherwise.
# SEEN a help text that begins with either is written as it is, and so is a paragraph of the description. The page is
#   made without a warning; man leaves these lines out, and groff warns of an undefined macro.
# HERE The manual page is made by docs/site/man_page.py, which escapes them.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
{ python3 -m venv "$folder/venv" && "$folder/venv/bin/pip" install -q argparse-manpage==4.8; } >"$folder/log" 2>&1 || {
    tail -n 1 "$folder/log"
    exit 2
}

cat >"$folder/program.py" <<'PYTHON'
import argparse


def parser():
    made = argparse.ArgumentParser("say", description="Says a word.\n\n.profile is read first.",
                                   formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument("--word", help="'hello' is the usual one")
    made.add_argument("--times", help="how often it is said")
    return made
PYTHON
"$folder/venv/bin/argparse-manpage" --pyfile "$folder/program.py" --function parser --prog say --project-name say \
    >"$folder/say.1" 2>"$folder/warnings"

status=0
for text in "'hello' is the usual one" ".profile is read first." "how often it is said"; do
    grep -qxF -- "$text" "$folder/say.1" || status=1
    echo "a line of the page: $text"
done
[[ ! -s $folder/warnings ]] || status=1
exit "$status"
