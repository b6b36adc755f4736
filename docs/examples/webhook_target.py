"""A target of webhooks: verifies each event that comes, and prints its type and what it concerns.

python webhook_target.py PORT     reads the secret of the webhook (whsec_...) from WEBHOOK_SECRET
"""

import base64
import hmac
import json
import os
import sys
import time
from http.server import BaseHTTPRequestHandler, HTTPServer


def is_genuine(headers, body):
    """Return whether the signature is by the secret, and the event is less than five minutes old."""
    stamp = headers["webhook-timestamp"]
    signed = f"{headers['webhook-id']}.{stamp}.".encode() + body
    key = base64.b64decode(os.environ["WEBHOOK_SECRET"].removeprefix("whsec_"))
    own = "v1," + base64.b64encode(hmac.digest(key, signed, "sha256")).decode()
    known = any(hmac.compare_digest(own, given) for given in headers["webhook-signature"].split())
    return known and abs(time.time() - float(stamp)) < 300


class Target(BaseHTTPRequestHandler):
    def do_POST(self):
        body = self.rfile.read(int(self.headers["Content-Length"]))
        if is_genuine(self.headers, body):
            event = json.loads(body)
            print(event["type"], event["data"].get("robot", ""), flush=True)
            self.send_response(204)
        else:
            self.send_response(400)
        self.end_headers()

    def log_message(self, *_):
        pass


if len(sys.argv) != 2:
    sys.exit(__doc__)
HTTPServer(("127.0.0.1", int(sys.argv[1])), Target).serve_forever()
