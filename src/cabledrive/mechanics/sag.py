"""How much the sag of a rope stiffens it."""


def irvine_parameter(stiffness: float, tension: float, mean_squared_shear: float) -> float:
    r"""Irvine's parameter: how much the sag stiffens the string, for any distribution of weight.

    .. math:: \lambda^2 = \frac{12\,K\,\overline{V^2}}{T^3}

    With q alone, :math:`\overline{V^2} = (q l)^2/12`, this is the usual :math:`(q l/T)^2\,K/T`. A string
    is straight while it is far below 1; at :math:`4\pi^2` the first symmetric mode in the plane of sag has
    risen to the frequency of the first antisymmetric one.

    ``stiffness``: force per strain K of the string [N]; ``tension``: along it, T [N];
    ``mean_squared_shear``: mean of the squared transverse force V [N^2].

    References
    ----------
    .. [1] H. M. Irvine, *Cable Structures*, MIT Press, 1981, chapters 2 and 3.
    """
    return 12.0 * stiffness * mean_squared_shear / tension**3
