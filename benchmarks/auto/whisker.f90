! A tapered rod, clamped upright, whose tip sticks to a surface: a problem for AUTO-07p.
!
! Lengths in units of L, forces of E*I0/L^2, moments of E*I0/L. Unknowns are the shape x, y, phi
! over the arc length s and the moment m = B*phi', with B = d^4, d = 1 - (1 - 1/theta)*s.
! Parameters: 1 theta, 2 fx, 3 fy (the contact force), 4 x1 - x0 (tip from clamp), 5 eta,
! 9 the friction coefficient fx/fy that sticking needs, 10 the size of the force.

subroutine func(ndim, u, icp, par, ijac, f, dfdu, dfdp)
  implicit none
  integer, intent(in) :: ndim, icp(*), ijac
  double precision, intent(in) :: u(ndim), par(*)
  double precision, intent(out) :: f(ndim)
  double precision, intent(inout) :: dfdu(ndim, ndim), dfdp(ndim, *)
  double precision :: stiffness

  stiffness = (1 - (1 - 1 / par(1)) * u(5))**4
  f(1) = cos(u(3))
  f(2) = sin(u(3))
  f(3) = u(4) / stiffness
  f(4) = par(2) * sin(u(3)) - par(3) * cos(u(3))
  f(5) = 1
end subroutine func

! The rod stands straight, without load.
subroutine stpnt(ndim, u, par, t)
  implicit none
  integer, intent(in) :: ndim
  double precision, intent(inout) :: u(ndim), par(*)
  double precision, intent(in) :: t

  par(1) = 2
  par(2:4) = 0
  par(5) = 1
  u(1) = 0
  u(2) = t
  u(3) = acos(0d0)
  u(4) = 0
  u(5) = t
end subroutine stpnt

subroutine bcnd(ndim, par, icp, nbc, u0, u1, fb, ijac, dbc)
  implicit none
  integer, intent(in) :: ndim, icp(*), nbc, ijac
  double precision, intent(in) :: par(*), u0(ndim), u1(ndim)
  double precision, intent(out) :: fb(nbc)
  double precision, intent(inout) :: dbc(nbc, *)

  fb(1) = u0(1)
  fb(2) = u0(2)
  fb(3) = u0(3) - acos(0d0)
  fb(4) = u0(5)
  fb(5) = u1(4)
  fb(6) = u1(1) - par(4)
  fb(7) = u1(2) - par(5)
end subroutine bcnd

subroutine pvls(ndim, u, par)
  implicit none
  integer, intent(in) :: ndim
  double precision, intent(in) :: u(ndim)
  double precision, intent(inout) :: par(*)

  par(9) = 0
  if (par(3) /= 0) par(9) = par(2) / par(3)
  par(10) = hypot(par(2), par(3))
end subroutine pvls

subroutine icnd
end subroutine icnd

subroutine fopt
end subroutine fopt
