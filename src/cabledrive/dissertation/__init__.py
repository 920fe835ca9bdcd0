"""The dissertation item by item: printed, computed, deviation, verdict."""

from cabledrive.dissertation.item import Entry, Item, Outcome
from cabledrive.dissertation.run import Reproduction, reproduce

__all__ = ["Entry", "Item", "Outcome", "Reproduction", "reproduce"]
