"""Messages about refused input: the received value, the wanted one, and the parameter to set."""

from dataclasses import dataclass

from .native import NS


@dataclass(frozen=True)
class Received:
    """Facts about a refused message, for its explanation.

    ``frame`` is the message's, ``wanted`` the node's by the parameters ``named``; ``stamp`` and
    ``now`` [ns] are the message's time and the node's; ``timeout`` [s] is the parameter
    ``patience``.
    """

    frame: str
    wanted: str
    stamp: int
    now: int
    timeout: float
    patience: str
    named: str = "base_frame"

    def explained(self, reason: str) -> str:
        """The reason, with the received and the wanted value; "" without a reason."""
        late = NS * (self.now - self.stamp)
        more = {
            "wrong frame": f"it is {self.frame!r}, wanted is {self.wanted!r} (set {self.named})",
            "too old": f"{late:.3g} s by its stamp, at most {self.timeout:g} s ({self.patience})",
            "from the future": f"its stamp is {-late:.3g} s ahead of this node's clock: "
            "synchronise the clocks of both machines",
        }
        return f"{reason}: {more[reason]}" if reason in more else reason
