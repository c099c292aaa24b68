"""
The least thickness of an arch
==============================

The least thickness of a semicircular arch is 0.1075 of its radius (Milankovitch 1907; Heyman
1969 rounds it to 0.106).
"""

from drystone.limits import limit_thickness
from drystone.models import arch

limit = limit_thickness(lambda t: arch(thickness_ratio=t), thick=0.2, thin=0.05, friction=0.9)
print(limit)
