"""Log in as a robot of Rapyuta, configure the cloud by a client file of rce-ros, and print what comes back.

python rapyuta_check.py FILE [SECONDS]; the password is read from standard input.
"""

import hashlib
import json
import sys
import time
import urllib.parse
import urllib.request
from contextlib import suppress
from pathlib import Path

from websockets.sync.client import connect

NODE = {"cTag": "containerTag", "nTag": "nodeTag"}
INTERFACE = {"eTag": "endpointTag", "iTag": "interfaceTag", "iType": "interfaceType", "iCls": "className"}


def spelled(items, names):
    return [{names.get(key, key): value for key, value in item.items()} for item in items]


def messages(file):
    for container in file["containers"]:
        yield "CC", {"containerTag": container["cTag"]}
    yield "CN", {"addNodes": spelled(file["nodes"], NODE), "setParam": spelled(file["parameters"], NODE)}
    yield "CN", {"addInterfaces": spelled(file["interfaces"], INTERFACE)}
    yield "CX", {"connect": file["connections"]}


def main():
    file = json.loads(Path(sys.argv[1]).read_text())
    end = time.monotonic() + (float(sys.argv[2]) if len(sys.argv) > 2 else 10.0)
    digest = hashlib.sha256(sys.stdin.readline().rstrip("\n").encode()).hexdigest()
    master = {"userID": file["userID"], "version": "20130902"}
    with urllib.request.urlopen(f"{file['url']}?{urllib.parse.urlencode(master)}") as answer:
        url = json.loads(answer.read())["url"]
    login = {"userID": file["userID"], "robotID": file["robotID"], "password": digest}
    with connect(f"{url}?{urllib.parse.urlencode(login)}", max_size=None) as socket:
        for kind, data in messages(file):
            socket.send(json.dumps({"type": kind, "data": data}))
        while time.monotonic() < end:
            with suppress(TimeoutError):
                print(socket.recv(timeout=end - time.monotonic())[:200], flush=True)


if len(sys.argv) not in (2, 3):
    sys.exit(__doc__)
main()
