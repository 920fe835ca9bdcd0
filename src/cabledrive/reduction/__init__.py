"""Models of few equations that keep what matters, each with the limits within which it may be trusted."""

from cabledrive.reduction.lumped_chain import LumpedChain

__all__ = ["LumpedChain"]
