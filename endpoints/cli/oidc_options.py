"""Options of the login with an identity provider; ``ppaas up`` and ``ppaas machine join`` have them."""

import argparse
from collections.abc import Callable
from pathlib import Path

from endpoints.oidc import settings
from ppaas.bounded import above_zero
from ppaas.errors import InvalidInput


def add(parser: argparse.ArgumentParser) -> None:
    """Add the options to a command."""
    _add_provider(parser)
    _add_people(parser)


def _add_provider(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--oidc-issuer", type=_checked(settings.issuer_url), metavar="URL",
        help="identity provider with which people may log in, by OpenID Connect, as its tokens name it (none)",
    )  # fmt: skip
    parser.add_argument("--oidc-client-id", metavar="ID", help="id under which the provider knows this cloud")
    parser.add_argument(
        "--oidc-client-secret-file", type=Path, metavar="FILE", help="secret of this client; read at each login (none)"
    )
    parser.add_argument(
        "--oidc-cloud-url", type=_checked(settings.secure_url), metavar="URL",
        help="address of this cloud for browsers; the provider must know its /dashboard/ as a redirect URI",
    )  # fmt: skip
    parser.add_argument("--oidc-name", metavar="NAME", help="name of the provider on the login page (its host)")
    parser.add_argument(
        "--oidc-scope", type=_checked(settings.scope), action="append", default=[], metavar="SCOPE",
        help="scope to ask for; may be repeated (openid, profile)",
    )  # fmt: skip
    parser.add_argument(
        "--oidc-algorithm", type=_checked(settings.algorithm), action="append", default=[], metavar="NAME",
        help=f"signature to take; may be repeated ({', '.join(settings.USUAL_ALGORITHMS)})",
    )  # fmt: skip
    parser.add_argument(
        "--oidc-audience", metavar="NAME",
        help="take access tokens of the provider for this audience, as programs have, for a token of the cloud (none)",
    )  # fmt: skip
    parser.add_argument(
        "--oidc-leeway", type=above_zero(600.0), default=60.0, metavar="SECONDS",
        help="difference between the clocks of provider and cloud that is tolerated (%(default)s)",
    )  # fmt: skip


def _add_people(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--oidc-role", type=_group_role, action="append", default=[], metavar="GROUP=ROLE",
        help="role of a group of the provider, admin or user; '*=user' for everybody; who is in no such group may not "
        "log in; may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--oidc-groups-claim", default="groups", metavar="NAME",
        help="claim with the groups of a person, as groups or realm_access.roles (%(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--oidc-username-claim", default="preferred_username", metavar="NAME",
        help="claim with the name of a new user (%(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--oidc-session", type=above_zero(30 * 86_400.0), default=43_200.0, metavar="SECONDS",
        help="time after which such a login ends (%(default)s)",
    )  # fmt: skip


def _checked(parse: Callable[[str], str]) -> Callable[[str], str]:
    """Return a type of arguments whose errors argparse reports."""

    def argument(text: str) -> str:
        try:
            return parse(text)
        except InvalidInput as error:
            raise argparse.ArgumentTypeError(str(error)) from error

    return argument


def _group_role(text: str) -> tuple[str, str]:
    try:
        return settings.group_role(text)
    except InvalidInput as error:
        raise argparse.ArgumentTypeError(str(error)) from error
