"""Who may look on and acknowledge: whoever has the token, from a page of this server and of no other."""

import hmac
import ipaddress
import secrets
import socket
from dataclasses import dataclass, field
from urllib.parse import urlsplit

TOKEN_BYTES = 18
NO_TOKEN = "The token is missing or wrong; open the address that the monitor printed when it started."
NO_HOST = "The monitor is reached by its number or as localhost, not by another name; open the address that it printed."
NO_ORIGIN = "A page of another server asks; open the monitor's own page."


@dataclass(frozen=True)
class PageAccess:
    """What is asked of whoever comes."""

    # That must be known; made anew unless given
    token: str = field(default_factory=lambda: secrets.token_urlsafe(TOKEN_BYTES), repr=False)

    def refusal(self, token: str, host: str, origin: str | None = None) -> str:
        """Return why somebody is refused, in a sentence; empty where nobody is."""
        if not _is_here(host):
            return NO_HOST
        if origin is not None and origin not in (f"http://{host}", f"https://{host}"):
            return NO_ORIGIN
        # In constant time, so that nobody can guess it letter by letter.
        return "" if hmac.compare_digest(token.encode(), self.token.encode()) else NO_TOKEN


def _is_here(host: str) -> bool:
    """Whether a host is a number or a name of this machine: a name of others may lead here without our knowledge."""
    try:
        name = (urlsplit(f"//{host}").hostname or "").rstrip(".")
    except ValueError:
        return False
    own = socket.gethostname().lower()
    if name in ("localhost", own, f"{own}.local"):
        return True
    try:
        return bool(ipaddress.ip_address(name))
    except ValueError:
        return False
