! Elasticity with the strength of Drucker and Prager, perfectly plastic: q <= M p + k with the pressure p, flow with
! M_psi in place of M; the return is along the radius, or to the apex. PROPS: E, nu, M, M_psi, k. STATEV: 1 while it
! yields (2 at the apex), plastic deviatoric strain.
subroutine umat(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, dstran, time, dtime, temp, &
                dtemp, predef, dpred, cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, drot, pnewdt, celent, &
                dfgrd0, dfgrd1, noel, npt, layer, kspt, kstep, kinc)
  implicit none
  character(80) :: cmname
  integer :: ndi, nshr, ntens, nstatv, nprops, noel, npt, layer, kspt, kstep(4), kinc
  real(8) :: stress(ntens), statev(nstatv), ddsdde(ntens, ntens), ddsddt(ntens), drplde(ntens), stran(ntens)
  real(8) :: dstran(ntens), time(2), predef(1), dpred(1), props(nprops), coords(3), drot(3, 3), dfgrd0(3, 3)
  real(8) :: dfgrd1(3, 3), sse, spd, scd, rpl, drpldt, dtime, temp, dtemp, pnewdt, celent
  real(8) :: bulk, g, friction, dilation, k, p, q, f, multiplier, hardness, share, s(6), n(6), e(6), volume, part
  integer :: i, j

  bulk = props(1)/(3.0d0*(1.0d0 - 2.0d0*props(2)))
  g = props(1)/(2.0d0*(1.0d0 + props(2)))
  friction = props(3)
  dilation = props(4)
  k = props(5)
  p = -sum(stress(1:3))/3.0d0
  volume = sum(dstran(1:3))
  do i = 1, ntens
    s(i) = stress(i) + merge(p, 0.0d0, i <= 3)
    e(i) = merge(dstran(i) - volume/3.0d0, 0.5d0*dstran(i), i <= 3)
    s(i) = s(i) + 2.0d0*g*e(i)
  end do
  p = p - bulk*volume
  q = sqrt(1.5d0*(sum(s(1:3)**2) + 2.0d0*sum(s(4:ntens)**2)))
  f = q - friction*p - k
  ddsdde = 0.0d0
  statev(1) = 0.0d0
  share = 1.0d0
  if (f > 0.0d0) then
    hardness = 3.0d0*g + bulk*friction*dilation
    multiplier = f/hardness
    statev(1) = 1.0d0
    if (q - 3.0d0*g*multiplier < 0.0d0) then
      statev(1) = 2.0d0
      statev(2) = statev(2) + q/(3.0d0*g)
      do i = 1, ntens
        stress(i) = merge(k/friction, 0.0d0, i <= 3)
      end do
      return
    end if
    statev(2) = statev(2) + multiplier
    n(1:ntens) = sqrt(1.5d0)*s(1:ntens)/q
    share = 1.0d0 - 3.0d0*g*multiplier/q
    s = share*s
    p = p + bulk*dilation*multiplier
  end if
  do i = 1, ntens
    stress(i) = s(i) - merge(p, 0.0d0, i <= 3)
    ddsdde(i, i) = merge(2.0d0, 1.0d0, i <= 3)*share*g
  end do
  ddsdde(1:3, 1:3) = ddsdde(1:3, 1:3) + bulk - 2.0d0/3.0d0*share*g
  if (f > 0.0d0) then
    ! With d q = sqrt(6) g n:d_e and d p = -bulk d_volume of the trial: d multiplier = (d q - friction d p)/hardness.
    do j = 1, ntens
      part = (sqrt(6.0d0)*g*n(j) + merge(friction*bulk, 0.0d0, j <= 3))/hardness
      do i = 1, ntens
        ddsdde(i, j) = ddsdde(i, j) - sqrt(6.0d0)*g*n(i)*(part - multiplier/q*sqrt(6.0d0)*g*n(j))
        if (i <= 3) ddsdde(i, j) = ddsdde(i, j) - bulk*dilation*part
      end do
    end do
  end if
end subroutine umat
